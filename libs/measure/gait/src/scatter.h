// What markers scatter about smooth paths: measurement noise, and the movement of skin on top of it. Not part of the
// interface.
#pragma once

#include <span>
#include <vector>

namespace lake::gait {

// One residual r of a smooth path, against the variance σ² of the measurement's noise.
struct Residual {
  double time_s = 0;
  double square = 0;  // (r/σ)², per axis
  double free = 0;    // 1 − leverage: what noise alone would leave of it, on average
};

// The share of the residuals around each moment that is noise, 0..1; the rest the marker did itself. Smooth path plus
// the rest of the residual has the smallest expected error: Stein's unbiased estimate of it, σ² (1 − 2 c free) + c² r²,
// is least at c = Σ free / Σ (r/σ)² (C. Stein, Annals of Statistics 9, 1981), and at most σ², the measurement's own.
// Where there is no residual within reach, that of all. Residuals and times must not decrease.
std::vector<double> NoiseShares(std::span<const Residual> residuals, std::span<const double> time_s);

// How likely it is, at each moment, that a movement is no longer what it was where it was seen last or is seen next,
// which goes on for about `memory_s`; `usual_s` lies between samples. Times must not decrease.
std::vector<double> ChancesOfChange(std::span<const double> at_s, std::span<const double> seen_s, double usual_s,
                                    double memory_s);

// What a marker does beside its smooth path where it is not seen, as a variance in those of its noise, per moment (0
// where it is seen): as much as beside the gap or, with the chance of change, the 95 % quantile of where it is seen.
std::vector<double> ScatterInGaps(std::span<const double> noise_shares, std::span<const char> seen,
                                  std::span<const double> time_s, double memory_s);

// The share of a residual by which the estimate leaves the measurement, where the residual is so many times the noise's
// deviation: no farther than a few of these deviations, as what moved in one frame only is not to be seen in the shares
// around it (limited translation: B. Efron & C. Morris, Journal of the American Statistical Association 67, 1972).
double LimitedShare(double share, double deviations);

// What is stated of noise around each moment and not to be seen in the residuals, in variances of a measurement (1: all
// of it). It is too slow to be told from motion: it is in the path, and must be in the path's variance.
std::vector<double> SlowNoise(std::span<const Residual> residuals, std::span<const double> time_s);

}  // namespace lake::gait
