// The intervals of the misalignment's parts: as often around the truth as they say.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "closed_form.h"
#include "lake/compare/misalignment.h"
#include "lake/compare/pointwise_error.h"

namespace lake {
namespace {

constexpr int kDraws = 60;

struct Truth {
  const char* name;
  compare::StsCurve human, exo;
  double replacement_sd_mm;
};

// A bump to and fro across the path, which neither placement nor timing makes.
void AddShape(double size_mm, compare::StsCurve& exo) {
  const compare::StsCurve before = exo;
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i)
    exo.knee[i] +=
        compare::ShankAxes(before, i).col(1) * size_mm * std::sin(6 * std::numbers::pi * static_cast<double>(i) / 100);
}

std::vector<Truth> Truths() {
  const compare::StsCurve human = MakeCurve({});
  Truth placed{"placement alone", human, MakeCurve({}, [](double s) { return s; }, {8, -5}), 0};
  Truth all{"all three", human, MakeCurve({}, IssueWarp, {8, -5}), 0};
  AddShape(1.5, all.exo);
  Truth replaced{"all three, markers put back elsewhere", human, all.exo, 1};
  return {placed, all, replaced};
}

constexpr double kSigma_mm = 0.3;

// Noise of a marker's sigma, alike over 2 % of the rise as the options have it: white noise through a window.
void AddFilteredNoise(compare::StsCurve& curve, std::mt19937& random) {
  constexpr int kReach = 6;
  const double width = compare::MisalignmentOptions{}.noise_width_percent / std::sqrt(2.0);
  std::normal_distribution<double> normal(0, kSigma_mm);
  std::vector<Eigen::Vector2d> white;
  for (int i = 0; i < compare::kPercentSamples + 2 * kReach; ++i) {
    const double x = normal(random), y = normal(random);
    white.emplace_back(x, y);
  }
  double power = 0;
  for (int k = -kReach; k <= kReach; ++k) power += std::exp(-std::pow(k / width, 2));
  for (int i = 0; i < compare::kPercentSamples; ++i)
    for (int k = -kReach; k <= kReach; ++k)
      curve.knee[static_cast<std::size_t>(i)] +=
          std::exp(-0.5 * std::pow(k / width, 2)) / std::sqrt(power) * white[static_cast<std::size_t>(i + k + kReach)];
  curve.knee_sigma_mm.assign(compare::kPercentSamples, kSigma_mm);
}

// The trial as it is measured: noise on both knees, the exoskeleton's marker put back elsewhere.
compare::Misalignment Measure(const Truth& truth, unsigned seed) {
  std::mt19937 random(seed);
  compare::StsCurve human = truth.human, exo = truth.exo;
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random);
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i)
    exo.knee[i] += compare::ShankAxes(truth.human, i) * truth.replacement_sd_mm * Eigen::Vector2d(x, y);
  AddFilteredNoise(human, random), AddFilteredNoise(exo, random);
  compare::MisalignmentOptions options;
  options.resamples = 100;
  options.replacement_sd_mm = truth.replacement_sd_mm;
  return compare::CompareTrials({{human}, {}}, {{exo}, {}}, options);
}

double Rms(const std::vector<Eigen::Vector2d>& vectors) {
  return std::sqrt(compare::MeanSquare(vectors));
}

struct Coverage {
  int held = 0;
  double low = 0, high = 0;  // means

  void Add(const compare::Interval& interval, double truth) {
    held += interval.low <= truth && truth <= interval.high;
    low += interval.low / kDraws, high += interval.high / kDraws;
  }
};

TEST(Intervals, OfThePartsHoldTheTruthAsOftenAsTheySay) {
  int all_held = 0, all = 0;
  for (const Truth& truth : Truths()) {
    const compare::Decomposition parts = compare::Decompose(truth.human, truth.exo);
    Coverage placement, timing, shape, x, y, placement_mm, timing_mm, shape_mm;
    for (unsigned seed = 0; seed < kDraws; ++seed) {
      const compare::Misalignment m = Measure(truth, seed);
      placement.Add(m.intervals->placement, parts.placement), timing.Add(m.intervals->timing, parts.timing);
      shape.Add(m.intervals->shape, parts.shape);
      placement_mm.Add(m.intervals->placement_mm, Rms(parts.placement_mm));
      timing_mm.Add(m.intervals->timing_mm, Rms(parts.timing_mm));
      shape_mm.Add(m.intervals->shape_mm, Rms(parts.shape_mm));
      x.Add(m.intervals->offset_x_mm, parts.offset_mm.x()), y.Add(m.intervals->offset_y_mm, parts.offset_mm.y());
    }
    // 95 % of 60 draws are 57 +- 1.7; the resamples are few and the noise of h(w) is drawn as if it were e's, which
    // costs some percent (51 to 58 are reached, 55 in the mean).
    for (const auto& [name, coverage] :
         {std::pair("placement", placement), std::pair("timing", timing), std::pair("shape", shape), std::pair("x", x),
          std::pair("y", y), std::pair("placement, mm", placement_mm), std::pair("timing, mm", timing_mm),
          std::pair("shape, mm", shape_mm)}) {
      EXPECT_GE(coverage.held, 0.8 * kDraws)
          << truth.name << ": " << name << ", " << coverage.low << " to " << coverage.high;
      all_held += coverage.held, all += kDraws;
    }
    // Noise is no shape: in the mean the interval lies around what there is without it.
    EXPECT_LE(shape.low, parts.shape) << truth.name;
    EXPECT_GE(shape.high, parts.shape) << truth.name;
  }
  EXPECT_GE(all_held, 0.88 * all);
}

TEST(Intervals, ATrialWithItselfHasNoParts) {
  const compare::StsCurve human = MakeCurve({});
  const compare::Misalignment m = compare::CompareTrials({{human}, {}}, {{human}, {}});
  EXPECT_EQ(m.metrics.rms_mm, 0);
  EXPECT_TRUE(std::isnan(m.decomposition.placement));
  EXPECT_THAT(m.warnings, testing::ElementsAre(testing::HasSubstr("both knee paths are one")));
  const Json parts = compare::ComparisonJson(m)["decomposition"];
  for (const char* part : {"placement", "timing", "shape"}) {
    EXPECT_TRUE(parts[part]["fraction"].is_null()) << part;
    EXPECT_TRUE(parts[part]["interval"].is_null()) << part;
  }
}

}  // namespace
}  // namespace lake
