#include "lake/compare/decomposition.h"

#include <gtest/gtest.h>

#include "closed_form.h"

namespace lake {
namespace {

constexpr int kSeeds = 12;

double RmsDistance(const compare::StsCurve& a, const compare::StsCurve& b) {
  double sum = 0;
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i)
    sum += (a.knee[i] - b.knee[i]).squaredNorm() / compare::kPercentSamples;
  return std::sqrt(sum);
}

// Adds noise of a tenth of the misalignment, as the issue has it: misalignment ≥ 10 × the noise (2-D RMS).
void AddTenthOfNoise(const compare::StsCurve& human, compare::StsCurve& exo, unsigned seed) {
  std::mt19937 random(seed);
  AddNoise(exo, 0.1 * RmsDistance(human, exo) / std::sqrt(2.0), random);
}

TEST(Decompose, PlacementIsPlacement) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const double angle_rad = 2 * std::numbers::pi * seed / kSeeds, size_mm = 5 + seed;
    const Eigen::Vector2d offset_mm = size_mm * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
    const compare::StsCurve human = MakeCurve({});
    compare::StsCurve exo = MakeCurve(
        {}, [](double s) { return s; }, offset_mm);
    const compare::Decomposition clean = compare::Decompose(human, exo);
    EXPECT_NEAR(clean.placement, 1, 1e-3) << offset_mm.transpose();
    EXPECT_LT((clean.offset_mm - offset_mm).norm(), 0.01);
    AddTenthOfNoise(human, exo, seed);
    const compare::Decomposition noisy = compare::Decompose(human, exo);
    EXPECT_GE(noisy.placement, 0.95) << offset_mm.transpose();
    EXPECT_NEAR(noisy.placement + noisy.timing + noisy.shape, 1, 1e-9);
  }
}

TEST(Decompose, PlacementIsRecoveredFromNoisyPaths) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const Eigen::Vector2d offset_mm(8, -5);
    const compare::StsCurve human = MakeCurve({});
    compare::StsCurve exo = MakeCurve({}, IssueWarp, offset_mm);
    std::mt19937 random(seed);
    AddNoise(exo, 0.3, random);  // per axis; three times what a good recording leaves
    EXPECT_LT((compare::Decompose(human, exo).offset_mm - offset_mm).norm(), 0.3) << seed;
  }
}

TEST(Decompose, TimeWarpIsTiming) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    for (const double amount : {0.05, -0.05, 0.1}) {
      const compare::StsCurve human = MakeCurve({});
      compare::StsCurve exo = MakeCurve({}, [&](double s) { return s + amount * std::sin(std::numbers::pi * s); });
      const compare::Decomposition clean = compare::Decompose(human, exo);
      EXPECT_GE(clean.timing, 0.99) << amount;
      for (int i = 15; i <= 85; ++i)  // at the ends the knee rests and its time is nowhere to be read
        EXPECT_NEAR(clean.timing_percent[static_cast<std::size_t>(i)],
                    100 * amount * std::sin(std::numbers::pi * i / 100), 0.5)
            << i;
      AddTenthOfNoise(human, exo, seed);
      EXPECT_GE(compare::Decompose(human, exo).timing, 0.95) << amount << ", seed " << seed;
    }
  }
}

TEST(Decompose, BothAtOnceComeApart) {
  const Eigen::Vector2d offset_mm(8, -5);
  const compare::StsCurve human = MakeCurve({}), exo = MakeCurve({}, IssueWarp, offset_mm);
  const compare::Decomposition d = compare::Decompose(human, exo);
  EXPECT_LT((d.offset_mm - offset_mm).norm(), 0.3);
  EXPECT_NEAR(d.timing_percent[50], 5, 0.5);
  EXPECT_NEAR(d.shape, 0, 0.01);
}

TEST(Decompose, AnotherPathIsShape) {
  // A bump to and fro across the path: neither a shift nor another pace makes it.
  const compare::StsCurve human = MakeCurve({});
  compare::StsCurve exo = human;
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i)
    exo.knee[i] +=
        compare::ShankAxes(human, i).col(1) * 6 * std::sin(6 * std::numbers::pi * static_cast<double>(i) / 100);
  EXPECT_GT(compare::Decompose(human, exo).shape, 0.9);
}

TEST(Decompose, PartsSumToTheDifference) {
  const compare::StsCurve human = MakeCurve({});
  ClosedFormLeg other;
  other.peak_shank_deg = 24;
  other.shank_mm = 430;
  const compare::StsCurve exo = MakeCurve(other, IssueWarp);
  const compare::Decomposition d = compare::Decompose(human, exo);
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i)
    EXPECT_LT((d.placement_mm[i] + d.timing_mm[i] + d.shape_mm[i] - (exo.knee[i] - human.knee[i])).norm(), 1e-9);
  EXPECT_NEAR(d.placement + d.timing + d.shape, 1, 1e-12);
}

TEST(Decompose, TimingStaysMonotoneAndInRange) {
  // A warp that nearly stands still in the middle, beyond what the least slope of 0.05 allows.
  const compare::StsCurve human = MakeCurve({});
  const compare::StsCurve exo =
      MakeCurve({}, [](double s) { return s < 0.5 ? std::min(s * 1.4, 0.5) : std::max(0.5, 1.4 * s - 0.4); });
  const compare::Decomposition d = compare::Decompose(human, exo);
  for (std::size_t k = 1; k < d.knots_percent.size(); ++k)
    EXPECT_GE(d.knots_percent[k] - d.knots_percent[k - 1], 0.05 * 12.5 - 1e-6);
  EXPECT_GE(d.knots_percent.front(), 0);
  EXPECT_LE(d.knots_percent.back(), 100);
}

TEST(Decompose, EqualPathsHaveNoParts) {
  const compare::StsCurve human = MakeCurve({});
  const compare::Decomposition d = compare::Decompose(human, human);
  EXPECT_TRUE(std::isnan(d.placement));
  EXPECT_LT(d.offset_mm.norm(), 1e-6);
}

}  // namespace
}  // namespace lake
