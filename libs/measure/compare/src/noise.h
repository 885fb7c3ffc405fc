// What chance does to a mean curve: for intervals and the noise floor.
#pragma once

#include <random>
#include <vector>

#include "lake/compare/interval.h"
#include "lake/compare/misalignment.h"

namespace lake::compare {

// What is known of how one repetition strays from the mean of many, beside what the trial's own repetitions show.
struct Variation {
  double width_percent = 2;     // over which a marker's noise is correlated
  double event_sd_s = 0;        // of onset and standing, beside what the fit says of their times
  double progress_percent = 0;  // a person's own: how far along the rise is half way through it, standard deviation
  double lean_deg = 0;          // … and the shank's lean
  double freedom = 0;           // as many degrees of freedom as this knowledge is worth
};

// Mean squared error of the mean knee path, mm², as the recording shows it: from the differences between several
// repetitions, of a single one from its markers' sigmas. Per sample, over both axes.
std::vector<double> SquaredErrorOfMean(const RegisteredTrial& trial, const StsCurve& mean);

// A draw of the error of the mean knee path of a trial. Its variance is the repetitions' own, moderated by `known` as
// if that were `freedom` repetitions more (Smyth 2004, doi 10.2202/1544-6115.1027), and its tails are Student's t of
// both: `steadiness`, 0..1, is where among such people this one is. A mean read from a file has its markers' noise
// alone.
std::vector<Eigen::Vector2d> DrawErrorOfMean(const RegisteredTrial& trial, const StsCurve& mean, const Variation& known,
                                             double steadiness, std::mt19937_64& random);
double DrawSteadiness(std::mt19937_64& random);

// Errors of both mean knee paths, in the leg frame.
struct MeanErrors {
  std::vector<Eigen::Vector2d> human, exo;
};

// Draws of them: of the repetitions, and the knee marker of the exoskeleton trial is put back elsewhere, by one offset
// in the human's shank frame, `replacement_sd_mm` per axis.
class NoiseModel {
 public:
  NoiseModel(const RegisteredTrial& human, const RegisteredTrial& exo, const MisalignmentOptions& options);

  MeanErrors Draw(std::mt19937_64& random) const;
  // Mean square per sample of what both recordings and the replacement make, without what is known of other people.
  std::vector<double> Floor() const;

 private:
  const RegisteredTrial& human_;
  const RegisteredTrial& exo_;
  const MisalignmentOptions& options_;
  StsCurve human_mean_, exo_mean_;
};

// Sample by sample.
std::vector<Eigen::Vector2d> Sum(std::vector<Eigen::Vector2d> a, const std::vector<Eigen::Vector2d>& b);
std::vector<Eigen::Vector2d> Less(std::vector<Eigen::Vector2d> a, const std::vector<Eigen::Vector2d>& b);

// Of a size (RMS, maximum) of a curve that was estimated with noise in it, which the estimate is always within: from
// the least multiple of the curve with which 2.5 % of the draws reach its size, to the largest size that the draws
// around it have, less what noise of many dimensions adds to all of them. `draws`: of the noise.
Interval RmsInterval(const std::vector<Eigen::Vector2d>& curve, const std::vector<std::vector<Eigen::Vector2d>>& draws);
Interval MaxInterval(const std::vector<Eigen::Vector2d>& curve, const std::vector<std::vector<Eigen::Vector2d>>& draws);

}  // namespace lake::compare
