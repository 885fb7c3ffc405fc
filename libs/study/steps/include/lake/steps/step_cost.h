// What a step of a study takes of a machine.
#pragma once

#include <cstddef>
#include <vector>

namespace lake::steps {

struct StepCost {
  double seconds = 1;      // wall time, while other steps run beside it
  double memory_mb = 200;  // the most at a time, of its process and of the largest that it starts
};

// How long this machine takes for a fixed piece of work against the machine that expected costs were measured on: 1
// where it is as fast. Measured once, the least of some tries, 0.1 s in
// all.
double MachinePace();

// Of steps that each begin once those before them have ended, at most so many at a time, in their order: when the last
// has ended, and the most memory at a time. `before` has the places of the steps that each waits for.
StepCost CostOfAll(const std::vector<StepCost>& steps, const std::vector<std::vector<std::size_t>>& before,
                   int at_a_time);

}  // namespace lake::steps
