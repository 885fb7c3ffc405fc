// The comparison of actuators as a table and in the summary.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/synthesis/actuator_front.h"

namespace lake::commands {

// actuators_front.csv: a row per actuator and share.
void WriteActuatorFront(const std::vector<synthesis::ActuatorCurve>& curves, const std::filesystem::path& path);

// For the report: a line per actuator, against the person's own duration.
std::string ActuatorFrontText(const std::vector<synthesis::ActuatorCurve>& curves, double own_s);

Json ActuatorFrontJson(const std::vector<synthesis::ActuatorCurve>& curves, const problem::SynthesisProblem& problem);

}  // namespace lake::commands
