// What chance does to the difference of two mean curves: for intervals and the noise floor.
#pragma once

#include <random>
#include <vector>

#include "lake/compare/misalignment.h"

namespace lake::compare {

// Draws of the error of e(s) − h(s), in the leg frame:
//   the knee marker is put back elsewhere: one offset in the human's shank frame, `replacement_sd_mm` per axis;
//   several repetitions: they are drawn anew with replacement, their deviations from the mean widened by sqrt(n / (n −
//   1)); one repetition: marker noise of its sigmas, correlated over `noise_width_percent`.
class NoiseModel {
 public:
  NoiseModel(const RegisteredTrial& human, const RegisteredTrial& exo, const MisalignmentOptions& options);

  std::vector<Eigen::Vector2d> Draw(std::mt19937_64& random) const;

 private:
  std::vector<Eigen::Vector2d> DrawTrial(const RegisteredTrial& trial, const StsCurve& mean,
                                         std::mt19937_64& random) const;
  std::vector<Eigen::Vector2d> DrawMarkerNoise(const StsCurve& curve, std::mt19937_64& random) const;

  const RegisteredTrial& human_;
  const RegisteredTrial& exo_;
  const MisalignmentOptions& options_;
  StsCurve human_mean_, exo_mean_;
};

}  // namespace lake::compare
