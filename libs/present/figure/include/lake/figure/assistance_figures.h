// Figures of what actuators do along a load profile.
#pragma once

#include <filesystem>
#include <vector>

#include "lake/problem/assistance.h"
#include "lake/synthesis/actuator_front.h"

namespace lake::figure {

// Over the rise: the actuator's force with what it lifts, its speed with what it reaches under that force, its power.
void DrawAssistance(const std::filesystem::path& path, const problem::Assistance& assistance,
                    const problem::SynthesisProblem& problem);

// The shortest duration against the share of the moment, a line per actuator, its name at the end; lower bounds hollow;
// below, the actuators without a design, and why.
void DrawActuatorFront(const std::filesystem::path& path, const std::vector<synthesis::ActuatorCurve>& curves,
                       double own_duration_s);

}  // namespace lake::figure
