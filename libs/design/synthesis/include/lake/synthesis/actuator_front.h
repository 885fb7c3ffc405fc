// Each actuator of a catalogue with the links with which it gives a share of the knee's moment in the shortest time.
#pragma once

#include <string>
#include <vector>

#include "lake/problem/assistance.h"
#include "lake/synthesis/infeasibility.h"
#include "lake/synthesis/optimize.h"

namespace lake::synthesis {

// One actuator at one share.
struct FrontPoint {
  double assist = 0;
  bool solved = false;
  linkage::Links links;            // if solved
  double range_deg = 0;            // of these
  problem::Assistance assistance;  // of these; its shortest duration is NaN where the actuator's speed is not known
  bool is_on_front = false;        // no other actuator gives as much in less time; not where its speed is not known
};

struct ActuatorCurve {
  problem::SynthesisProblem problem;  // with the actuator
  std::vector<FrontPoint> points;     // ascending in share; from the first without a solution on there is none
  std::string failing;                // why not, from there; empty: all are solved
  std::vector<std::string> limits;    // that would have to give way there

  const problem::LinearActuator& Actuator() const { return *problem.actuator; }
  // nullptr if none is solved.
  const FrontPoint* Last() const;
};

// Each actuator's curve over the shares, ascending, which lie above 0 and not beyond 1. `problem` needs a load profile;
// its own actuator, share, duration and goal do not count. A share without a solution ends the curve, as every force
// and every duration grows with the share. Throws Error for a problem that fails its Check(), Interrupted on a signal.
std::vector<ActuatorCurve> FindActuatorFront(const problem::SynthesisProblem& problem,
                                             const std::vector<problem::LinearActuator>& actuators,
                                             const std::vector<double>& shares, const OptimizeOptions& options = {});

}  // namespace lake::synthesis
