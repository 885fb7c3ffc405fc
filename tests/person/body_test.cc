#include "lake/person/body.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/error.h"

namespace lake {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// Volume and centre of mass of a frustum, integrated in slices.
struct Solid {
  double volume_mm3 = 0, centre_from_proximal_mm = 0;
};
Solid Integrate(const person::LimbSegment& limb) {
  constexpr int kSlices = 20000;
  Solid solid;
  for (int i = 0; i < kSlices; ++i) {
    const double from_distal = limb.length_mm * (i + 0.5) / kSlices;
    const double slice = std::numbers::pi * std::pow(limb.RadiusAt(from_distal), 2) * limb.length_mm / kSlices;
    solid.volume_mm3 += slice;
    solid.centre_from_proximal_mm += slice * (limb.length_mm - from_distal);
  }
  solid.centre_from_proximal_mm /= solid.volume_mm3;
  return solid;
}

TEST(Body, SegmentsHaveThePublishedLengthMassAndCentre) {
  for (const auto& [height, mass] : {std::pair(1800.0, 80.0), std::pair(1500.0, 45.0), std::pair(2000.0, 130.0)}) {
    const person::Body body = person::BodyOf(height, mass);
    EXPECT_DOUBLE_EQ(body.thigh.length_mm, 0.245 * height);
    EXPECT_DOUBLE_EQ(body.shank.length_mm, 0.246 * height);
    const Solid thigh = Integrate(body.thigh), shank = Integrate(body.shank);
    // kg; the sum over 20000 slices is exact to 1e-8.
    EXPECT_NEAR(thigh.volume_mm3 * 1.05e-6, 0.100 * mass, 1e-6);
    EXPECT_NEAR(shank.volume_mm3 * 1.09e-6, 0.0465 * mass, 1e-6);
    EXPECT_NEAR(thigh.centre_from_proximal_mm / body.thigh.length_mm, 0.433, 1e-6);
    EXPECT_NEAR(shank.centre_from_proximal_mm / body.shank.length_mm, 0.433, 1e-6);
    // The two meet at the knee with nearly one girth, though each comes from its own mass.
    EXPECT_NEAR(body.thigh.distal_radius_mm / body.shank.proximal_radius_mm, 1, 0.02);
  }
}

TEST(Body, RefusesWhatIsNoBody) {
  EXPECT_THAT([] { person::BodyOf(180, 80); }, ThrowsMessage<Error>(HasSubstr("a body of 180 mm")));
  EXPECT_THAT([] { person::BodyOf(1800, 0); }, ThrowsMessage<Error>(HasSubstr("a body of 0 kg")));
  EXPECT_THAT([] { person::BodyOf(std::nan(""), 80); }, ThrowsMessage<Error>(HasSubstr("a body of nan mm")));
}

TEST(Body, TakesTheLengthsOfAPersonsOwnLeg) {
  const person::LegLengths leg{410, 400};
  const person::Body average = person::BodyOf(person::HeightOf_mm(leg), 67);
  EXPECT_NEAR(average.thigh.length_mm + average.shank.length_mm, 810, 1e-9);
  const person::Body own = person::WithLeg(average, leg);
  EXPECT_EQ(own.thigh.length_mm, 410);
  EXPECT_EQ(own.shank.length_mm, 400);
  EXPECT_NEAR(Integrate(own.thigh).volume_mm3 * 1.05e-6, 0.100 * 67, 1e-6);
  EXPECT_NEAR(Integrate(own.shank).volume_mm3 * 1.09e-6, 0.0465 * 67, 1e-6);
  EXPECT_DOUBLE_EQ(person::MassAtHeight_kg(900, 1800, 80), 20);
  EXPECT_THAT([&] { person::WithLeg(average, {41, 400}); }, ThrowsMessage<Error>(HasSubstr("a thigh of 41 mm")));
}

}  // namespace
}  // namespace lake
