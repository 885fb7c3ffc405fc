#include "lake/linkage/wear.h"

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

// The same distances by hand: seated, the thigh is level and the mount is the lowest part.
TEST(CheckWear, PublishedDesignOnThePapersBody) {
  const person::Body body = person::BodyOf(1800, 80);
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
                              person::BodyOf(1800, 80), options);
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
  const person::Body body = person::BodyOf(1800, 80);
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
                                                      person::BodyOf(1350, 40), {});
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
  const person::Body body = person::BodyOf(1800, 50);
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
  const person::Body body = person::BodyOf(1750, 70);
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
      const auto moved = [&](double direction_rad, double by_mm) {
        const Eigen::Vector2d shift = by_mm * Eigen::Vector2d(std::cos(direction_rad), std::sin(direction_rad));
        return Overlap(outline, from + shift, to + shift);
      };
      EXPECT_FALSE(moved(separation.direction_rad, -bare_mm + 0.01));
      if (bare_mm > -5) continue;  // points are up to 0.4 mm apart, and may pass by a corner that hardly overlaps
      for (int k = 0; k < 90; ++k) EXPECT_TRUE(moved(k * std::numbers::pi / 45, -0.98 * bare_mm)) << k;
    }
  }
  EXPECT_GT(apart, 20);
  EXPECT_GT(overlapping, 20);
}

TEST(SeatClearance, IsTheDistanceToTheSeatsCorner) {
  const person::Body body = person::BodyOf(1750, 70);
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
  EXPECT_NEAR(apart.direction_rad, 1.25 * std::numbers::pi, 1e-9);
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
  const person::Body body = person::BodyOf(1800, 80);
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
