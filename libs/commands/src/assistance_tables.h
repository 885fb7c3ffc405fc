// What an actuator does along a load profile, and how actuators compare, as tables and in the summary.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/problem/assistance.h"
#include "lake/synthesis/actuator_front.h"

namespace lake::commands {

// Writes assistance.csv and assistance.png/.svg, reports how fast the rise is, what decides it and how fast any linkage
// could be; returns the part of the summary.
Json WriteAssistance(const problem::Assistance& assistance, const problem::SynthesisProblem& problem, Run& run);

// actuators_front.csv: a row per actuator and share.
void WriteActuatorFront(const std::vector<synthesis::ActuatorCurve>& curves, const std::filesystem::path& path);

// For the report: a line per actuator, against the person's own duration.
std::string ActuatorFrontText(const std::vector<synthesis::ActuatorCurve>& curves, double own_s);

Json ActuatorFrontJson(const std::vector<synthesis::ActuatorCurve>& curves, const problem::SynthesisProblem& problem);

}  // namespace lake::commands
