// What an actuator does along a load profile, as tables and in the summary.
#pragma once

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/problem/assistance.h"

namespace lake::commands {

// Writes assistance.csv and assistance.png/.svg, reports how fast the rise is, what decides it and how fast any linkage
// could be; returns the part of the summary.
Json WriteAssistance(const problem::Assistance& assistance, const problem::SynthesisProblem& problem, Run& run);

}  // namespace lake::commands
