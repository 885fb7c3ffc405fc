// Derivatives: analytic against ceres::Jet, both against central differences of the closed form.
#include <ceres/jet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "lake/linkage/linkage.h"
#include "lake/linkage/loop_equations.h"
#include "linkage/independent_routes.h"
#include "linkage/random_links.h"

namespace lake {
namespace {

constexpr int kVariables = 9;  // l1..l6, d, phi, theta
using Jet = ceres::Jet<double, kVariables>;

struct JetPoint {
  Jet l[6], d, phi, theta;
};

JetPoint JetsAt(const linkage::Links& links, const linkage::Pose& pose) {
  JetPoint point;
  for (int i = 0; i < 6; ++i) point.l[i] = Jet(links.Values()[i], i);
  point.d = Jet(pose.stroke_mm, 6);
  point.phi = Jet(pose.phi_rad, 7);
  point.theta = Jet(pose.theta_rad, 8);
  return point;
}

// d(phi, theta) / d(l1..l6, d) by the implicit function theorem on the Jets of the loops.
Eigen::Matrix<double, 2, 7> ImplicitDerivatives(const JetPoint& at) {
  const auto residuals = linkage::LoopResiduals(at.l, at.d, at.phi, at.theta);
  Eigen::Matrix2d by_angles;
  Eigen::Matrix<double, 2, 7> by_lengths;
  for (int row = 0; row < 2; ++row) {
    by_lengths.row(row) = residuals[row].v.head<7>();
    by_angles.row(row) = residuals[row].v.tail<2>();
  }
  return -by_angles.inverse() * by_lengths;
}

// A pose well inside its branch, so that the neighbours that differences need exist and curvature is tame.
struct Sample {
  linkage::Links links;
  linkage::Pose pose;
};
std::optional<Sample> NextSample(testing::RandomLinks& random) {
  const linkage::Links links = random.Next();
  const linkage::Pose pose = linkage::RequirePose(links, random.StrokeFor(links));
  const linkage::Transmission t = linkage::TransmissionOf(links, pose);
  if (std::min(std::sin(t.actuator_rad), std::sin(t.transmission_rad)) < 0.1) return std::nullopt;
  return Sample{links, pose};
}

constexpr int kSamples = 1500;

TEST(Derivatives, AnalyticEqualsJet) {
  testing::RandomLinks random;
  int compared = 0;
  for (int i = 0; i < kSamples; ++i) {
    const auto sample = NextSample(random);
    if (!sample) continue;
    const auto jets = ImplicitDerivatives(JetsAt(sample->links, sample->pose));
    const AngleDerivatives analytic = AngleDerivativesOf(sample->links, sample->pose);
    // Rounding only, relative to the largest entry.
    const double tolerance = 1e-10 * std::max(jets.row(1).cwiseAbs().maxCoeff(), 1e-3);
    for (int j = 0; j < 6; ++j) ASSERT_NEAR(analytic.link[j], jets(1, j), tolerance) << testing::TextOf(sample->links);
    ASSERT_NEAR(analytic.stroke, jets(1, 6), tolerance);
    ASSERT_NEAR(linkage::TransmissionOf(sample->links, sample->pose).radians_per_mm, analytic.stroke, tolerance);
    ++compared;
  }
  EXPECT_GT(compared, kSamples / 2);
}

TEST(Derivatives, AnalyticEqualsCentralDifferences) {
  testing::RandomLinks random;
  int compared = 0;
  for (int i = 0; i < kSamples; ++i) {
    const auto sample = NextSample(random);
    if (!sample) continue;
    const AngleDerivatives analytic = AngleDerivativesOf(sample->links, sample->pose);
    constexpr double kStep_mm = 1e-3;
    // Error of the difference: step^2 / 6 times the third derivative. With sines of at least 0.1 and lengths of at
    // least 10 mm that derivative stays below (slope + 1 / 10 mm) * 100 / mm^2, hence 2e-5 relative; rounding adds
    // 1e-12.
    const auto near = [&](double slope, double difference) {
      EXPECT_NEAR(slope, difference, 2e-5 * (std::abs(slope) + 0.1)) << testing::TextOf(sample->links);
    };
    const auto angle = [](const linkage::Links& links, double stroke) {
      return linkage::RequirePose(links, stroke).theta_rad;
    };
    const double d = sample->pose.stroke_mm;
    near(analytic.stroke, (angle(sample->links, d + kStep_mm) - angle(sample->links, d - kStep_mm)) / (2 * kStep_mm));
    for (int j = 0; j < 6; ++j) {
      auto above = sample->links.Values(), below = above;
      above[j] += kStep_mm;
      below[j] -= kStep_mm;
      near(
          analytic.link[j],
          (angle(linkage::Links::FromValues(above), d) - angle(linkage::Links::FromValues(below), d)) / (2 * kStep_mm));
    }
    ++compared;
  }
  EXPECT_GT(compared, kSamples / 2);
}

// The templates that a solver differentiates, variable by variable, also away from an assembled pose.
TEST(Derivatives, JetsOfTheTemplatesEqualCentralDifferences) {
  testing::RandomLinks random;
  const auto evaluate = [](const auto* x) {
    using T = std::decay_t<decltype(x[0])>;
    const auto loops = linkage::LoopResiduals(x, x[6], x[7], x[8]);
    const auto branch = linkage::BranchExpressions(x, x[7], x[8]);
    const auto transmission = linkage::SinCosTransmission(x, x[7], x[8]);
    const auto actuator = linkage::SinCosActuator(x, x[6], x[7], x[8]);
    const T stroke = linkage::StrokePerRadian(x, x[6], x[7], x[8]) / 100.0;
    return std::array<T, 9>{loops[0],        loops[1],    branch[0],   branch[1], transmission[0],
                            transmission[1], actuator[0], actuator[1], stroke};
  };
  for (int i = 0; i < 200; ++i) {
    const linkage::Links links = random.Next();
    std::array<double, kVariables> x{};
    const auto l = links.Values();
    std::copy(l.begin(), l.end(), x.begin());
    x[6] = random.Uniform(150, 400);
    x[7] = random.Uniform(0.5, 3);
    x[8] = random.Uniform(-0.5, 2.5);
    const auto v = linkage::LoopVectorsOf(x.data(), x[7], x[8]);
    if (std::abs(linkage::Dot(v.coupler, v.tip_motion)) < 1000) continue;  // d d / d theta has a pole at 0
    std::array<Jet, kVariables> jets;
    for (int j = 0; j < kVariables; ++j) jets[j] = Jet(x[j], j);
    const auto exact = evaluate(jets.data());
    for (int j = 0; j < kVariables; ++j) {
      const double step = j < 7 ? 1e-3 : 1e-5;
      auto above = x, below = x;
      above[j] += step;
      below[j] -= step;
      const auto high = evaluate(above.data()), low = evaluate(below.data());
      // Steps are 1e-5 of the variables' scale: truncation 1e-10 times a third derivative of modest size, rounding
      // 1e-10.
      for (std::size_t k = 0; k < exact.size(); ++k)
        ASSERT_NEAR(exact[k].v[j], (high[k] - low[k]) / (2 * step), 1e-5 * (1 + std::abs(exact[k].v[j])))
            << "value " << k << " by variable " << j << " of " << testing::TextOf(links);
    }
  }
}

}  // namespace
}  // namespace lake
