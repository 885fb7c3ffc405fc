#include "lake/gait/plausibility.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lake/core/error.h"
#include "synthetic_leg.h"

namespace lake {
namespace {

gait::LegFitResult Fitted(motion::LengthUnit unit = motion::LengthUnit::kMm) {
  const SyntheticLeg leg = MakeSyntheticLeg({}, 7);
  const gait::LegView view = unit == motion::LengthUnit::kMm ? ScaledView() : gait::LegView{};
  return gait::FitLeg(MakeTracks(leg.time_s, leg.points_mm, ScaledView(), {0.03}, 7), view);
}

void ExpectRefused(const gait::LegFitResult& result, const std::string& what) {
  try {
    gait::CheckPlausible(result);
    ADD_FAILURE() << what << " was taken";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr(what), testing::HasSubstr("100 to 102")));
  }
}

TEST(Plausibility, APersonsMotionPasses) {
  EXPECT_NO_THROW(gait::CheckPlausible(Fitted()));
  EXPECT_NO_THROW(gait::CheckPlausible(Fitted(motion::LengthUnit::kPx)));
}

TEST(Plausibility, WhatNoPersonDoesIsAnErrorWithItsFrames) {
  const gait::LegFitResult good = Fitted();
  const auto change = [&](const std::function<void(motion::LegSample&)>& spoil) {
    gait::LegFitResult bad = good;
    for (std::size_t i = 100; i <= 102; ++i) spoil(bad.motion.samples[i]);
    return bad;
  };
  ExpectRefused(change([](motion::LegSample& s) { s.knee_deg = -154.3; }), "knee angle is -154.3 deg");
  ExpectRefused(change([](motion::LegSample& s) { s.knee_deg = 190; }), "knee angle is 190 deg");
  ExpectRefused(change([](motion::LegSample& s) { s.ak *= 1.6; }), "shank");
  ExpectRefused(change([](motion::LegSample& s) { s.kh *= 0.4; }), "thigh");
  ExpectRefused(change([](motion::LegSample& s) { s.knee_deg_s = -5000; }), "angular velocity");
  ExpectRefused(change([](motion::LegSample& s) { s.knee_sigma_deg = 900; }), "standard deviation");
}

TEST(Plausibility, JumpsOfAnyMarkerAreRefused) {
  gait::LegFitResult bad = Fitted();
  for (std::size_t i = 100; i <= 102; ++i) bad.trajectory.markers[3].samples[i].position.x() += 2000;
  try {
    gait::CheckPlausible(bad);
    ADD_FAILURE() << "a jump of two metres was taken";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("the speed of marker 'waist'"));
  }
}

TEST(Plausibility, AFitThatExplainsLittleIsRefused) {
  gait::LegFitResult bad = Fitted();
  bad.markers[1].outliers = bad.markers[1].detected / 2;
  bad.outliers = {{100, bad.markers[1].name, 9, 9}, {101, bad.markers[1].name, 9, 9}, {102, bad.markers[1].name, 9, 9}};
  ExpectRefused(bad, "outliers of the fit");
}

}  // namespace
}  // namespace lake
