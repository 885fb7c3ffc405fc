// When to look for a rise: the knee was bent, is straighter by far, and keeps still. What a rise is, the leg fit says.
#pragma once

#include <deque>
#include <utility>

namespace lake::live {

class RiseWatch {
 public:
  // Frame by frame. True each time it is worth looking.
  bool Add(double time_s, double knee_deg);

 private:
  std::deque<std::pair<double, double>> last_;  // time and angle
  double most_deg_ = 0, least_deg_ = 0;
  double looked_s_ = 0;
  int looks_ = 0;
};

}  // namespace lake::live
