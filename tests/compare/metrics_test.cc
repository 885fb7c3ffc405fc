#include "lake/compare/metrics.h"

#include <ceres/jet.h>
#include <gmock/gmock.h>

#include "closed_form.h"
#include "lake/compare/misalignment.h"
#include "lake/compare/pointwise_error.h"

namespace lake {
namespace {

using Eigen::Vector2d;

TEST(PointwiseError, JetAgreesWithDoubleAndWithDifferences) {
  using Jet = ceres::Jet<double, 2>;
  const compare::StsCurve human = MakeCurve({});
  const std::vector<double> shank_mm = compare::ShankLengths(human);
  const auto shifted = [&](auto x, auto y) {
    std::vector<Eigen::Matrix<decltype(x), 2, 1>> path;
    for (const Vector2d& h : human.knee) path.push_back({x + h.x() * 1.01, y + h.y() * 0.99});
    return path;
  };
  const Jet error = compare::MeanSquaredMisalignment(shifted(Jet(3, 0), Jet(-2, 1)), human.knee, shank_mm);
  const auto value = [&](double x, double y) {
    return compare::MeanSquaredMisalignment(shifted(x, y), human.knee, shank_mm);
  };
  EXPECT_DOUBLE_EQ(error.a, value(3, -2));
  const double step = 1e-3;  // the error is quadratic in both: central differences are exact but for rounding
  EXPECT_NEAR(error.v[0], (value(3 + step, -2) - value(3 - step, -2)) / (2 * step), 1e-10);
  EXPECT_NEAR(error.v[1], (value(3, -2 + step) - value(3, -2 - step)) / (2 * step), 1e-10);
}

TEST(Metrics, OfAConstantShift) {
  const compare::StsCurve human = MakeCurve({});
  compare::StsCurve exo = human;
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i) exo.knee[i] += Vector2d(3, -4), exo.knee_deg[i] += 2;
  const compare::MisalignmentMetrics m =
      compare::ComputeMetrics(human, exo, std::vector<bool>(compare::kPercentSamples, true));
  EXPECT_NEAR(m.rms_mm, 5, 1e-12);
  EXPECT_NEAR(m.max_mm, 5, 1e-12);
  EXPECT_NEAR(m.p95_mm, 5, 1e-12);
  EXPECT_NEAR(m.relative_rms, 5.0 / 420, 1e-12);
  EXPECT_LE(m.closest_point_rms_mm, 5);
  EXPECT_GE(m.frechet_mm, m.hausdorff_mm);
  EXPECT_LE(m.frechet_mm, 5 + 1e-12);
  EXPECT_NEAR(m.knee_rmse_deg, 2, 1e-12);
  EXPECT_NEAR(m.linear_fit.slope, 1, 1e-12);
  EXPECT_NEAR(m.linear_fit.intercept, 2, 1e-10);
  EXPECT_NEAR(m.linear_fit.r2, 1, 1e-12);
  EXPECT_GT(m.relative_paper_rms, 4.0 / 421);
  EXPECT_LT(m.relative_paper_rms, 4.0 / 395);
}

TEST(Metrics, PathDistancesOfKnownPaths) {
  const std::vector<Vector2d> line = {{0, 0}, {10, 0}}, bent = {{0, 0}, {5, 3}, {10, 0}};
  EXPECT_DOUBLE_EQ(compare::DistanceToPath({5, 3}, line), 3);
  EXPECT_DOUBLE_EQ(compare::DistanceToPath({13, 4}, line), 5);
  EXPECT_DOUBLE_EQ(compare::HausdorffDistance(line, bent), 3);
  // The middle vertex has to be paired with an end.
  EXPECT_DOUBLE_EQ(compare::DiscreteFrechetDistance(line, bent), std::hypot(5, 3));
  // Back and forth: near everywhere, yet one cannot walk both without a long leash.
  const std::vector<Vector2d> forth = {{0, 0}, {5, 0}, {10, 0}}, back = {{0, 0}, {10, 0}, {0, 0}, {10, 0}};
  EXPECT_DOUBLE_EQ(compare::HausdorffDistance(forth, back), 0);
  EXPECT_DOUBLE_EQ(compare::DiscreteFrechetDistance(forth, back), 5);
}

TEST(Metrics, CoefficientOfMultipleCorrelation) {
  const std::vector<double> a = {0, 1, 2, 3};
  EXPECT_DOUBLE_EQ(compare::CoefficientOfMultipleCorrelation({a, a}), 1);
  // By hand, for 0 1 2 3 and 1 2 3 4: about the frame means 4 × 0.5 = 2 over 4; about the grand mean 2 (from 0..4): 12
  // over 7.
  EXPECT_NEAR(compare::CoefficientOfMultipleCorrelation({a, {1, 2, 3, 4}}), std::sqrt(1 - (2.0 / 4) / (12.0 / 7)),
              1e-12);
  EXPECT_TRUE(std::isnan(compare::CoefficientOfMultipleCorrelation({a, {3, 2, 1, 0}})));
}

TEST(Metrics, LinearFitMethod) {
  const compare::LinearFit fit = compare::FitLine({0, 1, 2, 3}, {1, 3, 5, 7});
  EXPECT_DOUBLE_EQ(fit.slope, 2);
  EXPECT_DOUBLE_EQ(fit.intercept, 1);
  EXPECT_DOUBLE_EQ(fit.r2, 1);
  EXPECT_TRUE(std::isnan(compare::FitLine({1, 1}, {0, 1}).slope));
}

TEST(Spikes, FoundWhereTheyAreAndNowhereElse) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    const compare::StsCurve human = MakeCurve({});
    compare::StsCurve exo = MakeCurve({}, IssueWarp, {5, 2});
    AddNoise(exo, 0.2, random);
    const std::vector<bool> none = compare::FindSpikes(human, exo);
    EXPECT_EQ(std::count(none.begin(), none.end(), true), 0) << seed;
    const std::size_t at = 10 + 4 * seed;
    for (std::size_t i = at; i < at + 3; ++i) exo.knee[i] += Vector2d(0, 15);
    const std::vector<bool> found = compare::FindSpikes(human, exo);
    for (std::size_t i = at; i < at + 3; ++i) EXPECT_TRUE(found[i]) << seed << " " << i;
    EXPECT_LE(std::count(found.begin(), found.end(), true), 5) << seed;
    std::vector<bool> quiet = found;
    quiet.flip();
    EXPECT_NEAR(compare::ComputeMetrics(human, exo, quiet).max_mm,
                compare::ComputeMetrics(human, MakeCurve({}, IssueWarp, {5, 2}), quiet).max_mm, 1.0);
  }
}

TEST(Spikes, CleanCurvesHaveNone) {
  const compare::StsCurve human = MakeCurve({});
  for (const double warp : {-0.08, 0.0, 0.05, 0.1}) {
    const compare::StsCurve exo =
        MakeCurve({}, [&](double s) { return s + warp * std::sin(std::numbers::pi * s); }, {10, 3});
    const std::vector<bool> spike = compare::FindSpikes(human, exo);
    EXPECT_EQ(std::count(spike.begin(), spike.end(), true), 0) << warp;
  }
}

// A pause of one of the two in mid-rise: 22 mm within a fifth of the rise, but no jump.
TEST(Spikes, QuickMotionIsNone) {
  const compare::StsCurve human = MakeCurve({});
  for (const double width : {8.0, 9.0, 12.0}) {
    compare::StsCurve exo = MakeCurve({}, IssueWarp, {20, 30});
    for (std::size_t i = 0; i < exo.knee.size(); ++i)
      exo.knee[i].x() += 22 * std::exp(-0.5 * std::pow((static_cast<double>(i) - 35) / width, 2));
    const std::vector<bool> spike = compare::FindSpikes(human, exo);
    EXPECT_EQ(std::count(spike.begin(), spike.end(), true), 0) << width;
  }
}

// The exoskeleton's joint lies beside the knee, so its distance from the ankle says nothing of the subject or the
// scale.
TEST(CompareTrials, WarnOfAnotherLegNotOfAJointBesideTheKnee) {
  const auto warnings = [](const compare::StsCurve& exo) {
    compare::MisalignmentOptions options;
    options.intervals = false;
    const compare::Misalignment m = compare::CompareTrials({{MakeCurve({})}, {}}, {{exo}, {}}, options);
    return testing::PrintToString(m.warnings);
  };
  EXPECT_THAT(warnings(MakeCurve({}, IssueWarp, {18, 60})), testing::Not(testing::HasSubstr("ankle to hip")));
  ClosedFormLeg other;
  other.shank_mm *= 1.07;
  other.thigh_mm *= 1.07;
  EXPECT_THAT(warnings(MakeCurve(other)), testing::HasSubstr("ankle to hip"));
}

}  // namespace
}  // namespace lake
