// The time by which one signal follows another, by their multiple correlation.
//
// y is predicted from x by a linear map, y(t) = x(t + offset + drift (t - from)) C + c + e(t), so that scales, axes and
// camera directions do not matter. Offset and drift minimise U, the share of y's variance that the best map leaves:
// coarse search over all lags, then the minimum of a parabola in both. Their covariance is that of the jackknife
// (Quenouille 1956; Künsch 1989 for blocks of a time series), which leaves out one block of time after another, widened
// by Student's t for the number of blocks. The drift has the prior 0 ± drift_sd.
#pragma once

#include <vector>

#include "lake/sync/series.h"

namespace lake::sync {

struct LagOptions {
  double drift_sd = 0;         // s/s, 1 SD; 0: no drift
  double reach_s = 0;          // the offset is at most this, either way; 0: any
  double least_overlap_s = 4;  // of times at which both are known
  double most_sd_s = 0.01;     // of a time within the overlap, else it is refused
  double tolerance_s = 0.004;  // by which the blocks' offsets may differ beyond their noise, 1 SD
};

enum class LagRefusal {
  kNone,
  kTooShort,       // for four blocks that are independent of one another
  kUnexplained,    // the map leaves more than 0.3 of y
  kAnother,        // another offset is nearly as likely
  kDrift,          // the clocks would run apart by more than 4 SD of the prior
  kContradiction,  // blocks have different offsets, as of two movements that are alike
  kUncertain,      // by more than most_sd_s
};

// A block of the overlap by itself.
struct BlockLag {
  double time_s = 0;       // its middle, on y's clock
  double departure_s = 0;  // its own offset less that of all
  double sd_s = 0;         // as if its size and its offset varied alike from block to block
};

struct Lag {
  LagRefusal refusal = LagRefusal::kNone;
  // When y's clock shows t, x's shows t + offset + drift (t - from); `from` is the middle of the overlap.
  double offset_s = 0, drift = 0, from_s = 0;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of offset and drift
  double free_drift = 0;                                 // without the prior, s/s,
  double free_drift_deviations = 0;                      // and in standard deviations of it and of the prior
  double unexplained = 1;                                // U
  double overlap_s = 0;                                  // from the first to the last time at which both are known
  double second_s = 0;                                   // the second-best offset
  std::vector<BlockLag> blocks = {};
  std::vector<double> search_s = {}, log_likelihood = {};          // over that of no map, of the coarse search
  std::vector<double> time_s = {}, measured = {}, predicted = {};  // y's first column; NaN between intervals

  double At(double y_time_s) const { return y_time_s + offset_s + drift * (y_time_s - from_s); }
  // 1 SD of At where it is largest, at an end of the overlap.
  double LargestSdS() const;
};

// Both series have the same step.
Lag FindLag(const Series& y, const Series& x, const LagOptions& options);

}  // namespace lake::sync
