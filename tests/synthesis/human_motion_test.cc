#include "lake/redesign/human_motion.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <random>

#include "compare/closed_form.h"
#include "lake/core/error.h"
#include "synthesis/paper.h"

namespace lake {
namespace {

using Eigen::Vector2d;

// A leg whose lengths are not constant, as of markers on skin.
compare::StsCurve SoftLeg(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  ClosedFormLeg leg;
  leg.shank_mm += 60 * unit(random);
  leg.thigh_mm += 60 * unit(random);
  leg.seated_knee_deg += 15 * unit(random);
  leg.standing_knee_deg += 4 * unit(random);
  compare::StsCurve curve = MakeCurve(leg);
  for (int i = 0; i < compare::kPercentSamples; ++i)
    for (std::vector<Vector2d>* path : {&curve.ankle, &curve.knee, &curve.hip})
      (*path)[i] += 5 * Vector2d{unit(random), unit(random)};
  return curve;
}

TEST(HumanMotion, AtTheHumansOwnAngleThePredictionIsTheHumansKnee) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const compare::StsCurve curve = SoftLeg(seed);
    const redesign::HumanMotion human = redesign::MakeHumanMotion(curve);
    for (std::size_t i = 0; i < human.size(); ++i) {
      EXPECT_LT((redesign::PredictKnee(human[i], human[i].knee_rad, 0.0, 0.0) - curve.knee[i]).norm(), 1e-9) << seed;
      // A placement is an offset in the shank's own axes.
      const Vector2d placement(12, -7);
      const Vector2d placed = curve.knee[i] + compare::ShankAxes(curve, i) * placement;
      EXPECT_LT((redesign::PredictKnee(human[i], human[i].knee_rad, placement.x(), placement.y()) - placed).norm(),
                1e-9);
    }
  }
}

TEST(HumanMotion, KneeAngleIsSigned) {
  ClosedFormLeg leg;
  leg.standing_knee_deg = -6;
  const redesign::HumanMotion human = redesign::MakeHumanMotion(MakeCurve(leg));
  EXPECT_NEAR(DegreesFromRadians(human.front().knee_rad), leg.seated_knee_deg, 1e-9);
  EXPECT_NEAR(DegreesFromRadians(human.back().knee_rad), -6, 1e-9);
}

// Another knee angle turns the shank about the ankle and keeps the direction of the hip.
TEST(HumanMotion, OtherAnglesKeepTheShankAndTheDirectionOfTheHip) {
  const compare::StsCurve curve = SoftLeg(3);
  const redesign::HumanMotion human = redesign::MakeHumanMotion(curve);
  for (const double theta : {-0.1, 0.0, 0.7, 1.9, 2.9})
    for (std::size_t i = 0; i < human.size(); i += 10) {
      const redesign::HumanSample& sample = human[i];
      const Vector2d shank = redesign::PredictKnee(sample, theta, 0.0, 0.0) - sample.ankle;
      EXPECT_NEAR(shank.norm(), sample.shank_mm, 1e-9);
      // The thigh leans back by theta from the shank; it must end on the human's line from ankle to hip.
      const Eigen::Rotation2Dd back(theta);
      const Vector2d hip = shank + sample.thigh_mm * (back * shank.normalized());
      const Vector2d along = curve.hip[i] - curve.ankle[i];
      EXPECT_NEAR(hip.x() * along.y() - hip.y() * along.x(), 0, 1e-6);
      EXPECT_GT(hip.dot(along), 0);
    }
}

TEST(HumanMotion, RefusesALegWithoutLength) {
  compare::StsCurve curve = MakeCurve({});
  curve.knee[17] = curve.ankle[17];
  EXPECT_THROW(redesign::MakeHumanMotion(curve), Error);
}

TEST(HumanMotion, TrackingStrokesGiveTheHumansAngles) {
  const redesign::HumanMotion human = redesign::MakeHumanMotion(MakeCurve({}));
  const auto strokes = redesign::TrackingStrokes({kPublishedLinks}, human);
  ASSERT_TRUE(strokes);
  for (std::size_t i = 0; i < human.size(); ++i)
    EXPECT_NEAR(linkage::SolvePose(kPublishedLinks, (*strokes)[i])->theta_rad, human[i].knee_rad, 1e-9);
  const auto prediction = redesign::Predict({kPublishedLinks}, {0, 0}, *strokes, human);
  ASSERT_TRUE(prediction);
  EXPECT_LT(prediction->path.relative, 1e-10);
}

TEST(HumanMotion, AnglesBeyondTheUsedRangeAreClamped) {
  ClosedFormLeg leg;
  leg.seated_knee_deg = 160;
  leg.standing_knee_deg = -5;
  const redesign::HumanMotion human = redesign::MakeHumanMotion(MakeCurve(leg));
  const auto strokes = redesign::TrackingStrokes({kPublishedLinks}, human);
  ASSERT_TRUE(strokes);
  EXPECT_EQ(strokes->front(), 242);              // the published design bends to 148.57 degrees
  EXPECT_NEAR(strokes->back(), 374.5205, 1e-4);  // its stroke at 0 degrees
  EXPECT_FALSE(redesign::TrackingStrokes({linkage::Links{10, 10, 10, 10, 50, 300}}, human));
}

TEST(HumanMotion, TrackingTimeIsThatOfTheSteepestPart) {
  std::vector<double> strokes;
  for (int i = 0; i < compare::kPercentSamples; ++i) strokes.push_back(i < 50 ? 300 : 300 + 2.0 * (i - 50));
  EXPECT_NEAR(redesign::TrackingTime(strokes, 5), 100 * 2.0 / 5, 1e-12);
  EXPECT_NEAR(redesign::TrackingTime(strokes, 10), 20, 1e-12);
}

TEST(HumanMotion, ProgramsBecomeStrokesPerPercent) {
  const redesign::HumanMotion human = redesign::MakeHumanMotion(MakeCurve({}));
  linkage::Design design;
  design.links = kPublishedLinks;
  const auto tracking = redesign::TrackingStrokes({kPublishedLinks}, human);
  const auto constant = redesign::ProgramStrokes(design, 0, human);
  ASSERT_TRUE(constant);
  for (int i = 0; i < compare::kPercentSamples; ++i)
    EXPECT_NEAR((*constant)[i], std::lerp(tracking->front(), tracking->back(), i / 100.0), 1e-9);
  design.program = linkage::StrokeProgram{linkage::StrokeProgram::Kind::kFree, 5, {{2, 250}, {3, 300}, {12, 320}}};
  const auto free = redesign::ProgramStrokes(design, 0, human);
  ASSERT_TRUE(free);
  EXPECT_NEAR(free->front(), 250, 1e-12);
  EXPECT_NEAR((*free)[5], 275, 1e-9);   // half a second on: half of the first second's way
  EXPECT_NEAR((*free)[55], 310, 1e-9);  // 7.5 s: half of the way from 3 to 12 s
  EXPECT_NEAR(free->back(), 320, 1e-12);
}

TEST(HumanMotion, StrokesOutsideTheUsedRangeHaveNoPrediction) {
  const redesign::HumanMotion human = redesign::MakeHumanMotion(MakeCurve({}));
  std::vector<double> strokes(compare::kPercentSamples, 300);
  EXPECT_TRUE(redesign::Predict({kPublishedLinks}, {0, 0}, strokes, human));
  strokes[40] = 241.9;
  EXPECT_FALSE(redesign::Predict({kPublishedLinks}, {0, 0}, strokes, human));
  strokes[40] = 375;  // beyond standing, where the knee would bend backward
  EXPECT_FALSE(redesign::Predict({kPublishedLinks}, {0, 0}, strokes, human));
}

// A leg of another pace and lean, its joint on a mount that slips along and across the shank.
struct SlippingTrial {
  compare::StsCurve exo;
  std::vector<Vector2d> slip;
};

SlippingTrial MakeSlippingTrial(const Vector2d& placement) {
  ClosedFormLeg leg;
  leg.peak_shank_deg = 27;
  leg.seated_shank_deg = 1;
  leg.shank_mm = 424;
  SlippingTrial trial;
  trial.exo = MakeCurve(leg, IssueWarp);
  trial.exo.leg_knee = trial.exo.knee;
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i) {
    const double u = static_cast<double>(i) / 100;
    trial.slip.emplace_back(2 * std::sin(7 * u), -5 * u);
    trial.exo.knee[i] += compare::ShankAxes(trial.exo, i) * (placement + trial.slip.back());
  }
  return trial;
}

TEST(HumanMotion, SlipIsToldFromPaceAndLean) {
  const Vector2d placement(18, 32);
  const SlippingTrial trial = MakeSlippingTrial(placement);
  const compare::StsCurve curve = MakeCurve({});
  redesign::HumanMotion human = redesign::MakeHumanMotion(curve);
  const auto found = redesign::SetSlip(trial.exo, {}, placement, human);
  ASSERT_TRUE(found);
  double square = 0;
  for (std::size_t i = 0; i < human.size(); ++i) {
    EXPECT_LT((human[i].slip_mm - trial.slip[i]).norm(), 1e-9) << i;
    square += trial.slip[i].squaredNorm() / compare::kPercentSamples;
    // Under the human's own pace and lean the joint is where placement and slip put it on the human's shank.
    const Vector2d joint = curve.knee[i] + compare::ShankAxes(curve, i) * (placement + trial.slip[i]);
    EXPECT_LT((redesign::PredictKnee(human[i], human[i].knee_rad, placement.x(), placement.y()) - joint).norm(), 1e-9)
        << i;
  }
  EXPECT_NEAR(found->slip_mm, std::sqrt(square), 1e-9);
  EXPECT_GT(found->pace_mm, 5);
  EXPECT_GT(found->lean_mm, 5);
  EXPECT_LT((found->placement_mm - placement).norm(), 5);
}

TEST(HumanMotion, ATrialThatDiffersInPaceAndLeanAloneHasNoSlip) {
  SlippingTrial trial = MakeSlippingTrial({0, 0});
  trial.exo.knee = trial.exo.leg_knee;
  redesign::HumanMotion human = redesign::MakeHumanMotion(MakeCurve({}));
  const auto found = redesign::SetSlip(trial.exo, {}, {0, 0}, human);
  ASSERT_TRUE(found);
  EXPECT_LT(found->slip_mm, 1e-9);
  EXPECT_GT(found->pace_mm + found->lean_mm, 10);
}

TEST(HumanMotion, SpikesDoNotEnterTheSlip) {
  const SlippingTrial clean = MakeSlippingTrial({18, 32});
  SlippingTrial spiked = clean;
  std::vector<bool> spike(compare::kPercentSamples, false);
  for (const std::size_t i : {0u, 40u, 41u, 100u}) spiked.exo.knee[i] += Vector2d(60, -80), spike[i] = true;
  redesign::HumanMotion human = redesign::MakeHumanMotion(MakeCurve({}));
  ASSERT_TRUE(redesign::SetSlip(spiked.exo, spike, {18, 32}, human));
  // Bridged from a neighbour: the slip changes by less than 0.2 mm per percent.
  for (std::size_t i = 0; i < human.size(); ++i) EXPECT_LT((human[i].slip_mm - clean.slip[i]).norm(), 0.2) << i;
}

TEST(HumanMotion, ATrialWithoutALegOfItsOwnHasNoSlip) {
  compare::StsCurve exo = MakeSlippingTrial({18, 32}).exo;
  exo.leg_knee.clear();
  redesign::HumanMotion human = redesign::MakeHumanMotion(MakeCurve({}));
  EXPECT_FALSE(redesign::SetSlip(exo, {}, {0, 0}, human));
  for (const redesign::HumanSample& sample : human) EXPECT_EQ(sample.slip_mm, Vector2d(0, 0));
}

// A prediction taken for a trial tells the very slip that it was made with.
TEST(HumanMotion, APredictedTrialShowsItsSlip) {
  redesign::HumanMotion human = redesign::MakeHumanMotion(SoftLeg(4)), other = redesign::MakeHumanMotion(MakeCurve({}));
  for (std::size_t i = 0; i < human.size(); ++i) human[i].slip_mm = {0.03 * static_cast<double>(i), -1};
  const auto prediction =
      redesign::Predict({kPublishedLinks}, {6, -3}, *redesign::TrackingStrokes({kPublishedLinks}, other), human);
  ASSERT_TRUE(prediction);
  ASSERT_TRUE(redesign::SetSlip(prediction->exo, {}, {6, -3}, other));
  for (std::size_t i = 0; i < human.size(); ++i) EXPECT_LT((other[i].slip_mm - human[i].slip_mm).norm(), 1e-9);
}

TEST(HumanMotion, ALongestStrokeEndsTheUsedRange) {
  const redesign::HumanMotion human = redesign::MakeHumanMotion(MakeCurve({}));
  redesign::DrivenLinks driven{kPublishedLinks};
  driven.d_max_mm = 340;
  EXPECT_EQ(redesign::TrackingStrokes(driven, human)->back(), 340);
  const std::vector<double> strokes(compare::kPercentSamples, 341);
  EXPECT_TRUE(redesign::Predict({kPublishedLinks}, {0, 0}, strokes, human));
  EXPECT_FALSE(redesign::Predict(driven, {0, 0}, strokes, human));
}

// A coarse search moves the same leg: the same percents, with what lies between them left out.
TEST(HumanMotion, ThinnedKeepsBothEndsAndWhereEachSampleIs) {
  const redesign::HumanMotion motion = redesign::MakeHumanMotion(MakeCurve({}));
  const redesign::HumanMotion thinned = redesign::Thinned(motion, 5);
  ASSERT_EQ(thinned.size(), 21u);
  for (std::size_t i = 0; i < thinned.size(); ++i) {
    EXPECT_EQ(redesign::PercentOf(i, thinned), redesign::PercentOf(5 * i, motion));
    EXPECT_EQ(thinned[i].knee, motion[5 * i].knee);
  }
}

}  // namespace
}  // namespace lake
