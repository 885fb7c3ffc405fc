// What an actuator does along a load profile, as tables and in the summary.
#pragma once

#include <string>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/problem/assistance.h"

namespace lake::commands {

// Writes assistance.csv and assistance.png/.svg; returns the part of the summary. Warns of what is not known.
Json WriteAssistance(const problem::Assistance& assistance, const problem::SynthesisProblem& problem, Run& run);

// How fast, what decides, and how fast any linkage could be.
std::string AssistanceText(const problem::Assistance& assistance, const problem::SynthesisProblem& problem);

}  // namespace lake::commands
