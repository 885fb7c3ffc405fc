// What a step of a study takes of a machine.
#pragma once

#include <cstddef>
#include <vector>

namespace lake::steps {

struct StepCost {
  double seconds = 1;      // wall time, with as many processors to itself as it keeps busy
  double memory_mb = 200;  // the most at a time, of its process and of the largest that it starts
  double processors = 1;   // that it keeps busy, on average over that time: processor time / seconds
};

// How long this machine takes for a fixed piece of work against the machine that expected costs were measured on: 1
// where it is as fast. Measured once, the least of some tries, 0.1 s in all.
double MachinePace();

struct CostsOfRun {
  StepCost all;                 // when the last has ended, and the most memory at a time
  std::vector<double> seconds;  // of each, from its beginning to its end, beside the others
};

// Of steps that each begin once those before them have ended, at most so many at a time, in their order, on so many
// processors. Steps that want more processors than there are share them in proportion, and all take longer. `before`
// has the places of the steps that each waits for.
CostsOfRun CostOfAll(const std::vector<StepCost>& steps, const std::vector<std::vector<std::size_t>>& before,
                     int at_a_time);

}  // namespace lake::steps
