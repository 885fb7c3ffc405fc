#include "lake/gait/plausibility.h"

#include <gmock/gmock.h>

#include "lake/core/error.h"
#include "message_of.h"
#include "synthetic_leg.h"

namespace lake {
namespace {

gait::LegFitResult Fitted(motion::LengthUnit unit = motion::LengthUnit::kMm) {
  const SyntheticLeg leg = MakeSyntheticLeg({}, 7);
  const gait::LegView view = unit == motion::LengthUnit::kMm ? ScaledView() : gait::LegView{};
  return gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, 7), view);
}

void ExpectRefused(const gait::LegFitResult& result, const std::string& what) {
  EXPECT_THAT(MessageOf([&] { gait::CheckPlausible(result.motion, result.trajectory); }),
              testing::AllOf(testing::HasSubstr(what), testing::HasSubstr("100 to 102")));
}

TEST(Plausibility, APersonsMotionPasses) {
  for (const motion::LengthUnit unit : {motion::LengthUnit::kMm, motion::LengthUnit::kPx}) {
    const gait::LegFitResult fit = Fitted(unit);
    EXPECT_NO_THROW(gait::CheckPlausible(fit.motion, fit.trajectory));
  }
}

TEST(Plausibility, WhatNoPersonDoesIsAnErrorWithItsFrames) {
  const gait::LegFitResult good = Fitted();
  const auto change = [&](const std::function<void(motion::LegSample&)>& spoil) {
    gait::LegFitResult bad = good;
    for (std::size_t i = 100; i <= 102; ++i) spoil(bad.motion.samples[i]);
    return bad;
  };
  ExpectRefused(change([](motion::LegSample& s) { s.knee_deg = -154.3; }), "knee angle is −154.3 deg");
  ExpectRefused(change([](motion::LegSample& s) { s.knee_deg = 190; }), "knee angle is 190 deg");
  ExpectRefused(change([](motion::LegSample& s) { s.ak *= 1.6; }), "shank");
  ExpectRefused(change([](motion::LegSample& s) { s.kh *= 0.4; }), "thigh");
  ExpectRefused(change([](motion::LegSample& s) { s.knee_deg_s = -5000; }), "angular velocity");
  ExpectRefused(change([](motion::LegSample& s) { s.knee_sigma_deg = 900; }), "standard deviation");
}

// A waist's marker near the hip's moves on the skin as well: the leg is a person's nonetheless.
TEST(Plausibility, ATrunkOfAnotherLengthIsTheWaistsFault) {
  gait::LegFitResult bad = Fitted();
  for (std::size_t i = 100; i <= 102; ++i) bad.motion.samples[i].hw *= 0.01;
  const std::vector<gait::Implausible> found = gait::FindImplausibleTrunk(bad.motion, {});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found[0].markers, testing::ElementsAre("waist"));
  EXPECT_EQ(gait::FramesOf(bad.motion.frame, found[0].at), "100 to 102");
  EXPECT_NO_THROW(gait::CheckPlausible(bad.motion, bad.trajectory));
}

TEST(Plausibility, JumpsOfAnyMarkerAreRefused) {
  gait::LegFitResult bad = Fitted();
  for (std::size_t i = 100; i <= 102; ++i) bad.trajectory.markers[3].samples[i].position.x() += 2000;
  EXPECT_THAT(MessageOf([&] { gait::CheckPlausible(bad.motion, bad.trajectory); }),
              testing::HasSubstr("the speed of marker 'waist'"));
}

// Of a trial of which a little is wrong, the rest is given: what no person does is left out, and said.
TEST(Plausibility, AFewBadFramesAreLeftOutAndSaid) {
  const SyntheticLeg leg = MakeSyntheticLeg({}, 7);
  for (const std::size_t marker : {0u, 1u, 2u}) {
    motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, 7);
    for (std::size_t i = 200; i < 202; ++i) tracks.markers[marker].samples[i].position += Eigen::Vector2d(250, -120);
    const gait::LegFitResult fit = gait::FitLeg(tracks, ScaledView());
    EXPECT_THAT(fit.warnings, testing::ElementsAre(testing::AllOf(testing::HasSubstr(tracks.markers[marker].name),
                                                                  testing::HasSubstr("frames 200 to 201"))));
    EXPECT_LT(CompareKnee(fit.motion, leg.truth).rms_deg, 0.05);
  }
}

// A lamp is the hip until the subject walks in. The path leads from the one to the other: up to five frames beside the
// change may be left out with the lamp's.
TEST(Plausibility, WhatWasTakenForAMarkerBeforeTheSubjectCameIsLeftOut) {
  const SyntheticLeg leg = MakeSyntheticLeg({}, 7);
  motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, 7);
  constexpr std::size_t kComes = 30;
  for (std::size_t i = 0; i < kComes; ++i)
    tracks.markers[2].samples[i].position = tracks.markers[2].samples[kComes].position + Eigen::Vector2d(-400, 100);
  const gait::LegFitResult fit = gait::FitLeg(tracks, ScaledView());
  EXPECT_THAT(fit.warnings, testing::Contains(testing::AllOf(testing::HasSubstr("'hip'"),
                                                             testing::AnyOf(testing::HasSubstr("frames 0 to 29"),
                                                                            testing::HasSubstr("frames 0 to 3")))));
  for (std::size_t i = 0; i < fit.motion.samples.size(); ++i)
    if (i < kComes || i >= kComes + 5) {
      EXPECT_EQ(std::isfinite(fit.motion.samples[i].knee_deg), i >= kComes) << i;
    }
}

// The knee's marker moved at random by up to so much in each direction, in each frame.
motion::MarkerRecording WithAKneeThatJumps(double by_mm) {
  const SyntheticLeg leg = MakeSyntheticLeg({}, 7);
  motion::MarkerRecording tracks = MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, 7);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> anywhere(-by_mm, by_mm);
  for (motion::MarkerSample& sample : tracks.markers[1].samples)
    sample.position += Eigen::Vector2d(anywhere(random), anywhere(random));
  return tracks;
}

TEST(Plausibility, AMarkerOfWhichMostFitsNoLegIsRefusedAndOneThatHardlyFitsReported) {
  EXPECT_THROW(gait::FitLeg(WithAKneeThatJumps(150), ScaledView()), Error);
  EXPECT_THAT(gait::FitLeg(WithAKneeThatJumps(40), ScaledView()).warnings, testing::Not(testing::IsEmpty()));
}

}  // namespace
}  // namespace lake
