#include "lake/linkage/body.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "published_links.h"

namespace lake {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// Volume and centre of mass of a frustum, integrated in slices.
struct Solid {
  double volume_mm3 = 0, centre_from_proximal_mm = 0;
};
Solid Integrate(const linkage::LimbSegment& limb) {
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
    const linkage::Body body = linkage::BodyOf(height, mass);
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
  EXPECT_THAT([] { linkage::BodyOf(180, 80); }, ThrowsMessage<Error>(HasSubstr("a body of 180 mm")));
  EXPECT_THAT([] { linkage::BodyOf(1800, 0); }, ThrowsMessage<Error>(HasSubstr("a body of 0 kg")));
  EXPECT_THAT([] { linkage::BodyOf(std::nan(""), 80); }, ThrowsMessage<Error>(HasSubstr("a body of nan mm")));
}

TEST(Body, TakesTheLengthsOfAPersonsOwnLeg) {
  const linkage::LegLengths leg{410, 400};
  const linkage::Body average = linkage::BodyOf(linkage::HeightOf_mm(leg), 67);
  EXPECT_NEAR(average.thigh.length_mm + average.shank.length_mm, 810, 1e-9);
  const linkage::Body own = linkage::WithLeg(average, leg);
  EXPECT_EQ(own.thigh.length_mm, 410);
  EXPECT_EQ(own.shank.length_mm, 400);
  EXPECT_NEAR(Integrate(own.thigh).volume_mm3 * 1.05e-6, 0.100 * 67, 1e-6);
  EXPECT_NEAR(Integrate(own.shank).volume_mm3 * 1.09e-6, 0.0465 * 67, 1e-6);
  EXPECT_DOUBLE_EQ(linkage::MassAtHeight_kg(900, 1800, 80), 20);
  EXPECT_THAT([&] { linkage::WithLeg(average, {41, 400}); }, ThrowsMessage<Error>(HasSubstr("a thigh of 41 mm")));
}

// The same distances by hand: seated, the thigh is level and the mount is the lowest part.
TEST(CheckWear, PublishedDesignOnThePapersBody) {
  const linkage::Body body = linkage::BodyOf(1800, 80);
  linkage::WearOptions options;
  options.mount = linkage::Mount::kBehind;
  const linkage::WearCheck check =
      linkage::CheckWear(kPublishedLinks, linkage::FindUsedRange(kPublishedLinks, 242, {}), body, options);
  EXPECT_NEAR(check.seated_deg, 90, 1e-9);
  EXPECT_NEAR(check.standing_deg, 0, 1e-9);
  const double mount_y = kPublishedLinks.l3 + kPublishedLinks.l6;
  EXPECT_NEAR(check.mount_below_hip_mm, 441 - mount_y - 12, 1e-9);
  EXPECT_NEAR(check.mount_behind_thigh_mm, 118.63 - body.thigh.RadiusAt(mount_y), 1e-9);
  // The actuator's round end lies this much below the seat's surface, far behind the seat's front edge at 220.5 mm.
  EXPECT_NEAR(check.seat_clearance_mm, body.thigh.proximal_radius_mm - (118.63 + 20), 1e-9);
  EXPECT_NEAR(check.seat_edge_needed_mm, mount_y + 20, 1e-9);
  EXPECT_TRUE(check.FitsAlongThigh());
  EXPECT_FALSE(check.ClearsSeat());
  EXPECT_FALSE(check.ClearsLimb());
}

// Beside the leg nothing is there to collide with, but a seat that is said to be wide or whose edge is.
TEST(CheckWear, BesideTheLegOnlyAWideSeatIsMet) {
  linkage::WearOptions options;
  const auto check = [&] {
    return linkage::CheckWear(kPublishedLinks, linkage::FindUsedRange(kPublishedLinks, 242, {}),
                              linkage::BodyOf(1800, 80), options);
  };
  const linkage::WearCheck beside = check();
  EXPECT_TRUE(beside.ClearsSeat());
  EXPECT_TRUE(beside.ClearsLimb());
  options.has_wide_seat = true;
  EXPECT_FALSE(check().ClearsSeat());
  EXPECT_TRUE(check().ClearsLimb());
  options.has_wide_seat = false;
  options.seat_edge_mm = 100;
  EXPECT_FALSE(check().ClearsSeat());
  options.mount = linkage::Mount::kBehind;
  EXPECT_FALSE(check().ClearsLimb());
  EXPECT_EQ(check().thigh_clearance_mm, beside.thigh_clearance_mm) << "judged or not";
}

TEST(CheckWear, ASeatThatEndsEarlierIsCleared) {
  const linkage::UsedRange range = linkage::FindUsedRange(kPublishedLinks, 242, {});
  const linkage::Body body = linkage::BodyOf(1800, 80);
  linkage::WearOptions options;
  const double needed = linkage::CheckWear(kPublishedLinks, range, body, options).seat_edge_needed_mm;
  options.seat_edge_mm = needed + 1;
  EXPECT_NEAR(linkage::CheckWear(kPublishedLinks, range, body, options).seat_clearance_mm, 1,
              0.05);  // sampled: 3 mm steps along a bar
  options.seat_edge_mm = needed - 1;
  EXPECT_LT(linkage::CheckWear(kPublishedLinks, range, body, options).seat_clearance_mm, 0);
}

TEST(CheckWear, AShortBodyHasNoRoomForTheMount) {
  const linkage::WearCheck check = linkage::CheckWear(kPublishedLinks, linkage::FindUsedRange(kPublishedLinks, 242, {}),
                                                      linkage::BodyOf(1350, 40), {});
  EXPECT_FALSE(check.FitsAlongThigh());
}

double DistanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const Eigen::Vector2d along = to - from;
  const double u = std::clamp((point - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (point - from - u * along).norm();
}

// A mount far behind a thin leg: the actuator clears the thigh all the way, by its distance to the thigh's hind edge
// and to its two ends.
TEST(CheckWear, AMountFarBehindClearsTheThigh) {
  const linkage::Links far{80, 160, 60, 150, 220, 220};
  const auto ranges = linkage::AssemblyRanges(far);
  ASSERT_FALSE(ranges.empty());
  const auto seated = linkage::StrokesForAngle(far, std::numbers::pi / 2),
             standing = linkage::StrokesForAngle(far, 1.2);
  ASSERT_FALSE(seated.empty());
  ASSERT_FALSE(standing.empty());
  const linkage::UsedRange range = linkage::FindUsedRange(far, seated.front(), standing.front());
  const linkage::Body body = linkage::BodyOf(1800, 50);
  const linkage::WearOptions options;
  const linkage::WearCheck check = linkage::CheckWear(far, range, body, options);
  const Eigen::Vector2d knee(0, 0), hip(0, body.thigh.length_mm), hind_knee(body.thigh.distal_radius_mm, 0),
      hind_hip(body.thigh.proximal_radius_mm, body.thigh.length_mm);
  double least_mm = HUGE_VAL, at_deg = 0;
  for (int i = 0; i <= 500; ++i) {
    const auto pose = linkage::SolvePose(far, range.stroke.lower_mm + range.stroke.Travel() * i / 500);
    ASSERT_TRUE(pose);
    for (int j = 0; j <= 1000; ++j) {
      const Eigen::Vector2d point = pose->mount + (pose->tip - pose->mount) * j / 1000;
      const double distance_mm =
          std::min({DistanceToSegment(point, knee, hind_knee), DistanceToSegment(point, hind_hip, hip),
                    DistanceToSegment(point, hind_knee, hind_hip)});
      if (distance_mm < least_mm) least_mm = distance_mm, at_deg = DegreesFromRadians(pose->theta_rad);
    }
  }
  // Poses and points are sampled five to ten times as finely as there: 3 mm along the actuator, 1 % of its stroke.
  EXPECT_NEAR(check.thigh_clearance_mm, least_mm - options.actuator_diameter_mm / 2, 0.1);
  EXPECT_NEAR(check.thigh_clearance_deg, at_deg, 1);
  EXPECT_GE(check.thigh_clearance_mm, 0);
}

// Between the outlines' sides, sampled; `apart` are the corners of a convex outline, a part by its two ends.
double LeastDistance(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& from,
                     const Eigen::Vector2d& to) {
  double least_mm = HUGE_VAL;
  constexpr int kPoints = 400;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    for (int j = 0; j <= kPoints; ++j) {
      least_mm = std::min(least_mm, DistanceToSegment(a + (b - a) * j / kPoints, from, to));
      least_mm = std::min(least_mm, DistanceToSegment(from + (to - from) * j / kPoints, a, b));
    }
  }
  return least_mm;
}

bool IsInside(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& point) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d side = outline[(i + 1) % outline.size()] - outline[i], to = point - outline[i];
    if (side.x() * to.y() - side.y() * to.x() < 0) return false;
  }
  return true;
}

bool Overlap(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  for (int i = 0; i <= 2000; ++i)
    if (IsInside(outline, from + (to - from) * i / 2000)) return true;
  return false;
}

// A pose with M and R anywhere about the knee, and any knee angle.
linkage::Pose RandomPlace(std::mt19937_64& random) {
  std::uniform_real_distribution<double> across(-150, 250), along(-200, 600), angle(0, 2.8);
  linkage::Pose pose;
  pose.mount = {across(random), along(random)};
  pose.tip = {across(random), along(random)};
  pose.theta_rad = angle(random);
  return pose;
}

TEST(LimbSeparation, IsTheDistanceApartAndTheShortestWayOut) {
  std::mt19937_64 random(7);
  const linkage::Body body = linkage::BodyOf(1750, 70);
  const linkage::WearOptions options;
  int apart = 0, overlapping = 0;
  for (int i = 0; i < 60; ++i) {
    const linkage::Pose pose = RandomPlace(random);
    for (const linkage::Limb limb : {linkage::Limb::kThigh, linkage::Limb::kShank}) {
      const auto corners = linkage::OutlineOf(limb, body);
      const std::vector<Eigen::Vector2d> outline(corners.begin(), corners.end());
      const auto from = linkage::InLimb(limb, pose.mount, pose.theta_rad),
                 to = linkage::InLimb(limb, pose.tip, pose.theta_rad);
      const linkage::Separation separation = linkage::LimbSeparation(limb, pose, body, options);
      const double bare_mm = separation.distance_mm + options.actuator_diameter_mm / 2;
      if (!Overlap(outline, from, to)) {
        ++apart;
        EXPECT_NEAR(bare_mm, LeastDistance(outline, from, to), 0.05);  // sampled: 2 mm steps, along smooth distances
        continue;
      }
      ++overlapping;
      ASSERT_LE(bare_mm, 0);
      // Moved so far in the direction it just touches; 2 % less in any of 90 directions is not enough.
      const auto moved = [&](double heading_rad, double by_mm) {
        const Eigen::Vector2d shift = by_mm * Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
        return Overlap(outline, from + shift, to + shift);
      };
      EXPECT_FALSE(moved(separation.heading_rad, -bare_mm + 0.01));
      if (bare_mm > -5) continue;  // points are up to 0.4 mm apart, and may pass by a corner that hardly overlaps
      for (int k = 0; k < 90; ++k) EXPECT_TRUE(moved(k * std::numbers::pi / 45, -0.98 * bare_mm)) << k;
    }
  }
  EXPECT_GT(apart, 20);
  EXPECT_GT(overlapping, 20);
}

TEST(SeatClearance, IsTheDistanceToTheSeatsCorner) {
  const linkage::Body body = linkage::BodyOf(1750, 70);
  linkage::WearOptions options;
  options.seat_edge_mm = 200;
  const linkage::Seat seat = linkage::SeatOf(body, options);
  EXPECT_EQ(seat.edge_mm, 200);
  linkage::Pose pose;  // a bar that passes before the corner and below the surface: 45 degrees, 10 mm off
  const Eigen::Vector2d corner(seat.surface_mm, seat.edge_mm), off = Eigen::Vector2d(-1, -1).normalized();
  const Eigen::Vector2d along = Eigen::Vector2d(1, -1).normalized();
  pose.mount = corner + 10 * off + 40 * along;
  pose.tip = corner + 10 * off - 40 * along;
  const auto parts = linkage::WornPartsOf(options);
  const linkage::Separation apart = linkage::SeparationFrom(seat, parts[0], pose);
  EXPECT_NEAR(apart.distance_mm, 10 - 20, 1e-9);
  EXPECT_NEAR(apart.heading_rad, 1.25 * std::numbers::pi, 1e-9);
}

// By hand: seated, forward is away from the hip, and up the shank is away from the seat.
TEST(PutOnBody, MovesThePinsWithThePlacement) {
  linkage::Pose pose = linkage::RequirePose(
      kPublishedLinks, *linkage::StrokeForAngle(kPublishedLinks, linkage::FindUsedRange(kPublishedLinks, 242, {}),
                                                std::numbers::pi / 2));
  const linkage::Pose placed = linkage::PutOnBody(pose, {13, 2});
  EXPECT_NEAR(placed.mount.x(), pose.mount.x() - 2, 1e-9);
  EXPECT_NEAR(placed.mount.y(), pose.mount.y() - 13, 1e-9);
  linkage::WearOptions options;
  options.placement_mm = {13, 2};
  const linkage::Body body = linkage::BodyOf(1800, 80);
  const auto check = [&] {
    return linkage::CheckWear(kPublishedLinks, linkage::FindUsedRange(kPublishedLinks, 242, {}), body, options);
  };
  const linkage::WearCheck moved = check();
  options.placement_mm = {0, 0};
  EXPECT_NEAR(moved.seat_clearance_mm, check().seat_clearance_mm + 2, 1e-9);
  EXPECT_NEAR(moved.mount_below_hip_mm, check().mount_below_hip_mm + 13, 1e-9);
}

}  // namespace
}  // namespace lake
