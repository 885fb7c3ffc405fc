// Figures of designs and of what they have to lift: PNG or SVG by the extension. All throw Error if they cannot be
// drawn.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/linkage/linkage.h"
#include "lake/loads/loads.h"
#include "lake/problem/assistance.h"
#include "lake/redesign/redesign_outcome.h"
#include "lake/synthesis/actuator_front.h"
#include "lake/synthesis/synthesis_outcome.h"

namespace lake::figure {

// The knee's moment over the rise, each rise and their mean with its 95 % band, before seat-off the bounds; the three
// joints' mean moments; where the ground's force acts, with the foot; the knee's power.
void DrawLoads(const std::filesystem::path& path, const loads::LoadsResult& result, const std::string& title);

// Range against the change of each link, one panel per link; where it cannot be assembled is shaded, where it leaves
// the bounds or violates a requirement on the links dashed.
void DrawSensitivity(const synthesis::SynthesisOutcome& outcome, const std::filesystem::path& path);

// Range (and yield, if estimated) against the margin from both singularities.
void DrawMargins(const synthesis::SynthesisOutcome& outcome, const std::filesystem::path& path);

// What Ipopt's cost stands for, `per_cost` of it and `objective` with its unit, and the errors over its iterations.
void DrawConvergence(const synthesis::LocalSolve& solve, const std::string& objective, double per_cost,
                     const std::filesystem::path& path);

// The design before and after in the human's motion: knee paths in the leg frame, misalignment, knee angle and stroke
// over percent.
void DrawKneePaths(const std::filesystem::path& path, const redesign::RedesignOutcome& outcome);

// Where the ground's force acts within the foot over the rise at the program's pace, of the design before, after and,
// where balance was required, without that; how trunk and leg lean; the knee's moment. The body must be known.
void DrawBalance(const std::filesystem::path& path, const redesign::RedesignOutcome& outcome);

// Over the rise: the actuator's force with what it lifts, its speed with what it reaches under that force, its power.
void DrawAssistance(const std::filesystem::path& path, const problem::Assistance& assistance,
                    const problem::SynthesisProblem& problem);

// The shortest duration against the share of the moment, a line per actuator, its name at the end; lower bounds hollow;
// below, the actuators without a design, and why.
void DrawActuatorFront(const std::filesystem::path& path, const std::vector<synthesis::ActuatorCurve>& curves,
                       double own_duration_s);

struct PinForcesRow {
  double stroke_mm = 0, knee_deg = 0;
  linkage::MemberForces forces;  // NaN where no torque is known
};

// Above along the members, push positive; below what the pins bear; over the knee angle. Near a dead point forces have
// no bound: the axes show five times the least that the largest pin force is.
void DrawPinForces(const std::filesystem::path& path, const std::vector<PinForcesRow>& rows);

}  // namespace lake::figure
