// How well what is computed from two trials is known. Not part of the interface.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "lake/compare/misalignment.h"

namespace lake::compare {

// Squared standard errors of estimates, and by how much chance moves them to one side on average: a size grows by noise
// in any direction.
struct Error {
  Eigen::ArrayXd variance, bias;
};

// Any number of quantities that a trial gives.
using OfTrial = std::function<Eigen::ArrayXd(const RegisteredTrial& trial)>;

// Of an estimate from at least two repetitions, `value`, by those that leave out one each: the jackknife (Quenouille
// 1956, Tukey 1958; Efron & Stein 1981, doi 10.1214/aos/1176345462). As many degrees of freedom as repetitions less
// one.
Error JackknifeError(const OfTrial& estimate, const RegisteredTrial& trial, const Eigen::ArrayXd& value);

// How many independent samples a mean over the rise has: noise is correlated over about two percent each way.
inline constexpr double kIndependentSamples = kPercentSamples / 5.0;
// Of whose noise the joint misalignment has its own: the exoskeleton's and the knee's.
inline constexpr double kMarkersOfAJoint = 2;

// Any number of quantities that two trials give.
using Estimate = std::function<Eigen::ArrayXd(const RegisteredTrial& human, const RegisteredTrial& exo)>;

// Of each of these quantities.
struct StandardErrors {
  Error error;
  Eigen::ArrayXd freedom;  // degrees of freedom

  // Around the value and around the one without bias.
  Interval Around(double value, Eigen::Index quantity) const;
};

// Two sources, added up with Satterthwaite's degrees of freedom:
// - Each trial's own variation, by the jackknife over its repetitions. Fewer than four are moderated by what is known
//   of people (options' progress, lean and events, and the markers' noise) as if that were `variation_freedom`
//   repetitions more (Smyth 2004, doi 10.2202/1544-6115.1027). A mean read from a file has its markers' noise alone.
// - The knee's marker of the exoskeleton trial, put back elsewhere.
StandardErrors FindStandardErrors(const Estimate& estimate, const RegisteredTrial& human, const RegisteredTrial& exo,
                                  const MisalignmentOptions& options);

}  // namespace lake::compare
