// A polynomial in time through a few positions. Not part of the interface.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace lake::tracking {

struct PathPoint {
  Eigen::Vector2d position, velocity, acceleration;  // px, px/s, px/s²
  double own_weight = 0;                             // of the sample at that time in the position; 0 if there is none
  double off_px = 0;                                 // of the samples from the path, root mean square, 2-D
};

// Least squares, about the time at which it is asked for; at equal intervals the filters of Savitzky & Golay (1964).
class LocalPath {
 public:
  LocalPath(int degree, double at_s) : degree_(degree), at_s_(at_s) {}

  void Add(double time_s, const Eigen::Vector2d& position) { samples_.push_back({time_s - at_s_, position}); }

  // With more samples than the degree.
  PathPoint Fit() const;

 private:
  struct Sample {
    double since_s;
    Eigen::Vector2d position;
  };
  int degree_;
  double at_s_;
  std::vector<Sample> samples_;
};

}  // namespace lake::tracking
