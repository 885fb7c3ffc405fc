// The budget's sensitivities against differences of the headlines themselves, and its intervals against draws.
#include "lake/compare/uncertainty_budget.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>
#include <tuple>

namespace lake::compare {
namespace {

using Eigen::Vector2d;
using testing::HasSubstr;

// A leg that extends by 90 degrees, with a joint that strays from a place on its shank as the knee bends.
StsCurve Worn(const Vector2d& joint_mm, const Vector2d& knee_error_mm = Vector2d::Zero(), double scale = 1) {
  StsCurve curve;
  for (int i = 0; i < kPercentSamples; ++i) {
    const double shank = (25 - 0.35 * i) * M_PI / 180, thigh = shank - (95 - 0.9 * i) * M_PI / 180;
    const Vector2d up(std::sin(shank), std::cos(shank)), forward(std::cos(shank), -std::sin(shank));
    const Vector2d joint = joint_mm + 0.05 * i * Vector2d(1, -0.5), ankle(0.02 * i, 0), knee = ankle + 400 * up;
    curve.ankle.push_back(scale * ankle);
    curve.leg_knee.push_back(scale * (knee + knee_error_mm.x() * forward + knee_error_mm.y() * up));
    curve.hip.push_back(scale * (knee + 410 * Vector2d(std::sin(thigh), std::cos(thigh))));
    curve.knee.push_back(scale * (knee + joint.x() * forward + joint.y() * up));
    curve.knee_deg.push_back(95 - 0.9 * i);
    curve.knee_sigma_mm.push_back(0.05);
  }
  curve.duration_s = 2;
  return curve;
}

Misalignment Measured(const StsCurve& exo) {
  Misalignment m;
  m.exo = exo;
  m.human = exo;
  m.human.knee = exo.leg_knee;
  m.joint = FindJointMisalignment({{exo}, {}}, std::vector<bool>(kPercentSamples, false));
  return m;
}

const Budget& Of(const std::vector<Budget>& budgets, const std::string& quantity) {
  return *std::ranges::find(budgets, quantity, &Budget::quantity);
}

const BudgetRow& Row(const Budget& budget, const std::string& source) {
  return *std::ranges::find(budget.rows, source, &BudgetRow::source);
}

// A knee marker that sits elsewhere by a random place of 7 mm per axis: the headline's own scatter is what soft tissue
// contributes. 400 draws know a standard deviation to 4 %; the RMS is not quite linear over 7 of 30 mm.
TEST(UncertaintyBudget, SoftTissueIsTheScatterOfItsDraws) {
  const Misalignment measured = Measured(Worn({18, 24}));
  const std::vector<Budget> budgets = BudgetsOf(measured, 3, {});
  std::mt19937 random(5);
  std::normal_distribution<double> error(0, 7);
  double rms_square = 0, x_square = 0;
  constexpr int kDraws = 400;
  for (int k = 0; k < kDraws; ++k) {
    const Vector2d knee(error(random), error(random));
    const JointMisalignment joint = *Measured(Worn({18, 24}, knee)).joint;
    rms_square += std::pow(joint.rms_mm - measured.joint->rms_mm, 2) / kDraws;
    x_square += std::pow(joint.mean_mm.x() - measured.joint->mean_mm.x(), 2) / kDraws;
  }
  EXPECT_NEAR(Row(Of(budgets, "joint_rms"), "soft tissue").Contribution() / std::sqrt(rms_square), 1, 0.15);
  EXPECT_NEAR(Row(Of(budgets, "joint_offset_x"), "soft tissue").Contribution() / std::sqrt(x_square), 1, 0.15);
}

TEST(UncertaintyBudget, ScaleIsADifferenceOfTheHeadline) {
  const Misalignment measured = Measured(Worn({18, 24}));
  ComparisonBudgetOptions options;
  options.scale_percent = 1;
  const double difference = Measured(Worn({18, 24}, Vector2d::Zero(), 1.01)).joint->rms_mm - measured.joint->rms_mm;
  EXPECT_NEAR(Row(Of(BudgetsOf(measured, 3, options), "joint_rms"), "lens and plane").Contribution(), difference, 1e-6);
}

// On skin the interval is as wide as published strays are; on a rendering only what the markers are.
TEST(UncertaintyBudget, TellsMarkersFromTheJointBeneath) {
  const Misalignment measured = Measured(Worn({18, 24}));
  const Budget skin = Of(BudgetsOf(measured, 3, {}), "joint_rms");
  EXPECT_GT(skin.AnatomicalInterval().high - skin.value, 13);  // Benoit et al.: 13.0 mm in walking
  EXPECT_LT(skin.AnatomicalInterval().high - skin.value, 20);
  EXPECT_LT(skin.MarkerInterval().high - skin.value, 3);
  EXPECT_THAT(WhatNarrows(skin), HasSubstr("two or more markers on shank and thigh"));
  ComparisonBudgetOptions rendered;
  rendered.soft_tissue_mm = 0;
  const Budget none = Of(BudgetsOf(measured, 0, rendered), "joint_rms");
  EXPECT_DOUBLE_EQ(none.MarkerDeviation(), none.Deviation());
  EXPECT_THAT(WhatNarrows(Of(BudgetsOf(measured, 9, rendered), "joint_rms")), HasSubstr("leave the same markers on"));
  for (const Budget& budget : BudgetsOf(measured, 3, {})) {
    double shares = 0;
    for (const BudgetRow& row : budget.rows) shares += budget.SharePercent(row);
    EXPECT_NEAR(shares, 100, 1e-9) << budget.quantity;
  }
}

// Soft tissue, placement and repetitions, each with its share and what to do about it; of repetitions also where they
// would not narrow it, or there is one alone.
TEST(UncertaintyBudget, SaysWhatWouldNarrowIt) {
  Budget budget = Of(BudgetsOf(Measured(Worn({18, 24})), 3, {}), "joint_rms");
  budget.rows.push_back({"the person's own variation", "t", 3, "mm", 1, "repetitions of this trial", true});
  const std::string text = WhatNarrows(budget);
  EXPECT_THAT(text, testing::MatchesRegex("7[0-9] % of the variance comes from soft tissue: two or more markers on "
                                          "shank and thigh, .*; 1[0-9] % from .*; 1[0-9] % from .*\\."));
  EXPECT_THAT(text, HasSubstr("% from marker placement: leave the same markers on between the trials"));
  EXPECT_THAT(text, HasSubstr("% from the person's own variation: record more repetitions"));
  const std::string angle = WhatNarrows(Of(BudgetsOf(Measured(Worn({18, 24})), 3, {}), "knee_angle"));
  EXPECT_THAT(angle, HasSubstr("% from soft tissue at ankle and hip: two or more markers on shank and thigh"));
  EXPECT_THAT(angle, HasSubstr("% from placement of ankle and hip: find malleolus and greater trochanter"));
  budget.rows.back().size = 0.3;
  EXPECT_THAT(
      WhatNarrows(budget),
      HasSubstr("; the scatter of the repetitions is less than 1 % of it: more repetitions would not narrow it."));
  budget.rows.pop_back();
  EXPECT_THAT(WhatNarrows(budget),
              HasSubstr("; one repetition does not show how far they differ: record more repetitions."));
  EXPECT_THAT(angle, testing::Not(HasSubstr("repetition"))) << "a frame is no mean of them";
}

// Against a skeletal model the knee angle of markers is off by 0.7 to 2.0 degrees on average and 7 in single frames.
TEST(UncertaintyBudget, TheKneeAngleOfSkinMarkersIsKnownToDegrees) {
  const Budget angle = Of(BudgetsOf(Measured(Worn({18, 24})), 3, {}), "knee_angle");
  EXPECT_GT(angle.Deviation(), 1);
  EXPECT_LT(angle.Deviation(), 3.5);
}

// Skin slides as the knee bends: a frame's joint is known less well than the rise's mean, unless the knee is the axis
// of two clusters; of a rendering, as the markers are.
TEST(UncertaintyBudget, ASingleFramesJointIsKnownLessThanTheMean) {
  const Misalignment measured = Measured(Worn({18, 24}));
  ComparisonBudgetOptions options;
  const auto deviation_mm = [&](const char* quantity) {
    return Of(BudgetsOf(measured, 3, options), quantity).Deviation();
  };
  EXPECT_NEAR(Row(Of(BudgetsOf(measured, 3, options), "joint_frame"), "soft tissue in a single frame").size, 14, 1e-12);
  EXPECT_GT(deviation_mm("joint_frame"), 1.5 * deviation_mm("joint_offset_x"));
  options.frame_tissue_mm = 20;
  EXPECT_NEAR(deviation_mm("joint_frame"), std::hypot(20, 3), 0.1);
  options.axes.exo_mm = 2;
  EXPECT_NEAR(deviation_mm("joint_frame"), deviation_mm("joint_offset_x"), 0.1);
  options = {};
  options.soft_tissue_mm = 0;
  const Budget rendered = Of(BudgetsOf(measured, 0, options), "joint_frame");
  EXPECT_DOUBLE_EQ(rendered.MarkerDeviation(), rendered.Deviation());
}

// Of a joint far above the knee or far before it, where a wrong scale is the larger part.
TEST(UncertaintyBudget, TheJointsPlaceIsAsUncertainAsAlongItsWorseAxis) {
  ComparisonBudgetOptions options;
  options.scale_percent = 10;
  for (const auto& [joint_mm, worse, other] : {std::tuple(Vector2d(5, 80), "joint_offset_y", "joint_offset_x"),
                                               std::tuple(Vector2d(80, 5), "joint_offset_x", "joint_offset_y")}) {
    const std::vector<Budget> budgets = BudgetsOf(Measured(Worn(joint_mm)), 3, options);
    EXPECT_EQ(PlaceDeviation(budgets), Of(budgets, worse).Deviation());
    EXPECT_GT(PlaceDeviation(budgets), Of(budgets, other).Deviation());
  }
  EXPECT_TRUE(std::isnan(PlaceDeviation({})));
}

// A camera 3 m away that sees the joint 0.6 m beside the point that it looks at straight on, as the joint is from the
// knee: a slope of 0.2 along it.
TEST(UncertaintyBudget, ParallaxIsTheDepthTimesTheTrialsOwnSlope) {
  Misalignment measured = Measured(Worn({30, 0}));
  measured.exo_sight.emplace().plane.camera_mm = {0, 0, 3000};
  for (int i = 0; i < kPercentSamples; ++i)
    measured.exo.slope.emplace_back(0.2 * AxesAlong(measured.exo.leg_knee[i] - measured.exo.ankle[i]).col(0));
  const auto of = [&](const char* quantity, const ComparisonBudgetOptions& options = {}) {
    return Row(Of(BudgetsOf(measured, 3, options), quantity), "out-of-plane movement and parallax").Contribution();
  };
  EXPECT_NEAR(of("joint_offset_x"), 0.2 * kJointDepth_mm, 1e-9);
  EXPECT_NEAR(of("joint_offset_y"), 0, 1e-9);
  EXPECT_NEAR(of("joint_rms"), 0.2 * kJointDepth_mm, 0.05);  // it grows along the offset, which turns by a few degrees
  EXPECT_THAT(WhatNarrows(Of(BudgetsOf(measured, 0, {}), "joint_rms")), HasSubstr("--depth exo_knee=MM±SD"));
  measured.exo_sight->depth = {40, 5};
  measured.exo_sight->plane.turn_sd_rad = 0.002;
  measured.exo_sight->plane.distance_sd_mm = 9;  // 0.3 %
  EXPECT_NEAR(of("joint_offset_x"), 0.2 * 5, 1e-9);
  const Budget known = Of(BudgetsOf(measured, 3, {}), "joint_offset_x");
  EXPECT_NEAR(Row(known, "turn of the plane").Contribution(), 0.002 * 40, 1e-9);
  EXPECT_NEAR(Row(known, "lens and plane").size, std::hypot(0.2, 0.3), 1e-9);
  measured.exo_sight->depth->sd_mm.reset();
  EXPECT_NEAR(of("joint_offset_x"), 0.2 * kSkinDepth_mm, 1e-9);
  ComparisonBudgetOptions said;
  said.depth_mm = 3;
  said.view_slope = 0.5;
  EXPECT_NEAR(of("joint_offset_y", said), 1.5, 1e-9);
}

// An error in any direction makes a small offset longer: the interval is of the truth all the same.
TEST(UncertaintyBudget, AJointAtTheKneeIsNotSaidToBeOffIt) {
  std::mt19937 random(7);
  std::normal_distribution<double> error(0, std::hypot(7, 3));
  for (const double truth_mm : {0.0, 3.0, 10.0, 25.0}) {
    int held = 0;
    constexpr int kDraws = 1000;
    for (int k = 0; k < kDraws; ++k) {
      Budget budget{"joint_rms", "mm", std::hypot(truth_mm + error(random), error(random)), 0, {}};
      budget.rows.push_back({"soft tissue", "normal", std::hypot(7, 3), "mm", 1, "", false});
      budget.size = {budget.value, 0, std::hypot(7, 3)};
      const Interval interval = budget.AnatomicalInterval();
      held += interval.low <= truth_mm && truth_mm <= interval.high;
    }
    EXPECT_GE(held, 0.935 * kDraws) << truth_mm;  // a standard deviation of 0.7 % below 95 %
    EXPECT_LE(held, 0.99 * kDraws) << truth_mm;
  }
}

// A joint at the knee whose marker slides: nothing tells that from a joint that moves, but for how far skin can slide.
TEST(UncertaintyBudget, WhatSkinSlidesWithinARiseMayBeNoMisalignment) {
  Budget budget{"joint_rms", "mm", 3, 0, {}};
  budget.rows.push_back({"soft tissue", "normal", 7, "mm", 1, "", false});
  budget.size = {.offset_mm = 1, .marker_sd_mm = 0.1, .sd_mm = 7, .skin_mm = 17};
  EXPECT_EQ(budget.AnatomicalInterval().low, 0);
  EXPECT_GT(budget.MarkerInterval().low, 2.8);
  budget.size->skin_mm = 2;
  EXPECT_NEAR(budget.AnatomicalInterval().low, 2, 1e-9);  // √(3² − 1² − 2²)
}

TEST(UncertaintyBudget, WithoutTheLegsOwnKneeOnlyTheAngle) {
  Misalignment measured = Measured(Worn({18, 24}));
  measured.joint.reset();
  const std::vector<Budget> budgets = BudgetsOf(measured, 3, {});
  ASSERT_EQ(budgets.size(), 1);
  EXPECT_EQ(budgets[0].quantity, "knee_angle");
}

// One recording: a knee marker 1 mm across the leg turns shank and thigh against each other by what the budget says.
TEST(UncertaintyBudget, OfOneRecordingTheKneeAngleOfAFrame) {
  gait::LegFitResult leg;
  leg.motion.unit = motion::LengthUnit::kMm;
  for (int i = 0; i < 50; ++i) {
    motion::LegSample sample;
    sample.ak = {0, 400};
    sample.kh = {0, 410};
    sample.knee_deg = 0;
    sample.knee_sigma_deg = 0.02;
    leg.motion.samples.push_back(sample);
  }
  const std::vector<Budget> budgets = BudgetsOf(leg, {});
  ASSERT_EQ(budgets.size(), 1u);  // no rise
  const double turned_deg = (std::atan2(1, 400) + std::atan2(1, 410)) * 180 / M_PI;
  EXPECT_NEAR(Row(budgets[0], "soft tissue").sensitivity, turned_deg, 1e-5 * turned_deg);
  EXPECT_NEAR(Row(budgets[0], "detection").Contribution(), 0.02, 1e-12);
  EXPECT_GT(budgets[0].Deviation(), 50 * 0.02);
  leg.motion.unit = motion::LengthUnit::kPx;
  EXPECT_TRUE(BudgetsOf(leg, {}).empty());
}

}  // namespace
}  // namespace lake::compare
