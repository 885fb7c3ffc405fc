// The pieces of which a linkage's nonlinear program is put together; each adds its variables and rows to a program.
//
// A pose is (stroke d, bar angle phi, knee angle theta) with the loop equations |R - M| = d, |R - S| = l1 as equality
// rows and alpha2 >= 0, beta2 >= 0 as branch rows. Where theta is not a variable of its own it is
//   theta = standing + fraction (range - standing),
// so a fixed set of fractions follows the used range while the range is optimised.
#pragma once

#include <array>
#include <initializer_list>
#include <string>
#include <vector>

#include "lake/linkage/wear.h"
#include "lake/nlp/nonlinear_program.h"
#include "lake/problem/problem.h"

namespace lake::synthesis {

// Indices of the variables l1..l6 in the program.
using LinkVariables = std::array<int, 6>;

LinkVariables AddLinks(nlp::NonlinearProgram& program, const std::array<problem::Bounds, 6>& bounds,
                       const linkage::Links& start);
linkage::Links LinksAt(const LinkVariables& links, const std::vector<double>& x);

// Indices of a pose's variables, and where in the used range it is.
struct PoseVariables {
  LinkVariables links;
  int stroke, phi, range;
  double fraction = 1, standing_rad = 0;
  std::string place;              // as its rows are named: " at 0.25"
  std::array<double, 6> shift{};  // of a build whose links are off by this

  // l1..l6, stroke, phi, range: what the terms of a pose take.
  std::array<int, 9> All() const;
};

// Adds phi and the rows of a pose; stroke and range are there already.
PoseVariables AddPose(nlp::NonlinearProgram& program, const std::string& name, const LinkVariables& links, int stroke,
                      int range, double fraction, double standing_rad, double phi_start_rad,
                      const std::array<double, 6>& shift = {});

// A stroke between those of two knots: (1 - weight) from + weight to.
struct StrokeBetween {
  int from, to;
  double weight;
};

// A pose on the way of a stroke program, with a knee angle of its own; adds phi and the same rows as AddPose, with
// fewer variables each.
void AddProgramPose(nlp::NonlinearProgram& program, const std::string& name, const LinkVariables& links,
                    const StrokeBetween& stroke, int theta, double phi_start_rad);

// u.R' > 0: bar and coupler are not in line, where the knee angle turns back and poses of two branches meet.
void AddNoTurningRow(nlp::NonlinearProgram& program, const PoseVariables& pose);

// The ratios of the requirement at one pose, each as a row, against the variable `limit`; multiplied out (limits.h), so
// smooth also where the moment arm is infinite.
void AddRatioRows(nlp::NonlinearProgram& program, const problem::Requirement& requirement, const PoseVariables& pose,
                  int limit, const problem::PoseLoad& load);

// What clears what at one pose: the variables of the pose, the limit and the placement of the exoskeleton's knee, and
// the pose where the program starts, on the body.
struct ClearancePose {
  PoseVariables pose;
  int limit;
  std::array<int, 2> placement;
  linkage::Pose start;
};

// Two convex outlines are `limit` apart if in some direction u = (cos, sin) they are; that separating direction is a
// variable, so that the rows are smooth and hold exactly where the distance does (linkage/wear.h).
//   u . (pin - corner) - radius >= limit                        for both pins of each part
void AddSeatRows(nlp::NonlinearProgram& program, const ClearancePose& at, const linkage::Seat& seat,
                 const linkage::WearOptions& wear);
//   u . pin - h - radius >= limit,  h >= u . corner             for the actuator's pins and the limb's corners
void AddLimbRows(nlp::NonlinearProgram& program, const ClearancePose& at, linkage::Limb limb, const person::Body& body,
                 const linkage::WearOptions& wear);

// coefficients . X, as a term of `row`.
void AddLinearTerm(nlp::NonlinearProgram& program, int row, const LinkVariables& links,
                   const std::array<double, 6>& coefficients);

// l2 + d - l7, as a term of `row`; of the build for which it is least, if each length may be off by `off_mm`.
void AddSingularityTerm(nlp::NonlinearProgram& program, int row, const LinkVariables& links, int stroke,
                        double off_mm = 0);

// factor x variable, as a term of `row` (NlpTerm::kCost: of the cost).
void AddScaledTerm(nlp::NonlinearProgram& program, int row, int variable, double factor);

// lower <= sum of factor x variable <= upper.
struct ScaledVariable {
  int variable;
  double factor;
};
int AddLinearRow(nlp::NonlinearProgram& program, const std::string& name, double lower, double upper,
                 std::initializer_list<ScaledVariable> terms);

}  // namespace lake::synthesis
