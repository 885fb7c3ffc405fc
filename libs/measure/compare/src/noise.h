// What chance does to the difference of two mean curves: for intervals and the noise floor.
#pragma once

#include <random>
#include <vector>

#include "lake/compare/misalignment.h"

namespace lake::compare {

// A draw of the error of the mean knee path of a trial. Several repetitions are drawn anew with replacement, their
// deviations from the mean widened by sqrt(n / (n − 1)); one repetition has marker noise of its sigmas, correlated over
// `width_percent`.
std::vector<Eigen::Vector2d> DrawErrorOfMean(const RegisteredTrial& trial, const StsCurve& mean, double width_percent,
                                             std::mt19937_64& random);

// Draws of the error of e(s) − h(s), in the leg frame: the errors of both means, and the knee marker is put back
// elsewhere, by one offset in the human's shank frame, `replacement_sd_mm` per axis.
class NoiseModel {
 public:
  NoiseModel(const RegisteredTrial& human, const RegisteredTrial& exo, const MisalignmentOptions& options);

  std::vector<Eigen::Vector2d> Draw(std::mt19937_64& random) const;

 private:
  const RegisteredTrial& human_;
  const RegisteredTrial& exo_;
  const MisalignmentOptions& options_;
  StsCurve human_mean_, exo_mean_;
};

}  // namespace lake::compare
