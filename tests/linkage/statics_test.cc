// Forces in members and pins against virtual work, against the balance of every body, and by hand.
#include "lake/linkage/statics.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <utility>
#include <vector>

#include "lake/linkage/linkage.h"
#include "linkage/random_links.h"

namespace lake {
namespace {

using Eigen::Vector2d;

double Moment(const Vector2d& at, const Vector2d& force) {
  return at.x() * force.y() - at.y() * force.x();
}

// A square: the actuator hangs plumb on the bar's end, the coupler too. 72 N m at 72 mm are 1000 N in both; the bar,
// across both, is free.
TEST(MemberForces, OfTheCheckPoseByHand) {
  const linkage::Pose pose = linkage::RequirePose({60, 72, 60, 72, 72, 240}, 240);
  const linkage::MemberForces forces = linkage::MemberForcesOf(pose, 72);
  constexpr double kRounding_n = 1e-9;
  EXPECT_NEAR(forces.actuator_n, 1000, kRounding_n);
  EXPECT_NEAR(forces.coupler_n, 1000, kRounding_n);
  EXPECT_NEAR(forces.bar_n, 0, kRounding_n);
  EXPECT_NEAR(forces.KneePin(), 1000, kRounding_n);
  EXPECT_NEAR(forces.TipPin(), 1000, kRounding_n);
}

// Poses a degree and more from both dead points, where forces are finite to many digits.
bool IsClear(const linkage::Transmission& transmission) {
  constexpr double kLeast = 0.02;
  return std::sin(transmission.transmission_rad) > kLeast && std::sin(transmission.actuator_rad) > kLeast &&
         std::isfinite(transmission.radians_per_mm) && transmission.moment_arm_mm > 1;
}

TEST(MemberForces, AgreeWithVirtualWorkAndBalanceEveryBody) {
  testing::RandomLinks random;
  int checked = 0;
  while (checked < 2000) {
    const linkage::Links links = random.Next();
    const linkage::Pose pose = linkage::RequirePose(links, random.StrokeFor(links));
    const linkage::Transmission transmission = linkage::TransmissionOf(links, pose);
    if (!IsClear(transmission)) continue;
    ++checked;
    const double torque_nm = random.Uniform(-120, 120);
    const linkage::MemberForces forces = linkage::MemberForcesOf(pose, torque_nm);
    const double rounding_n = 1e-9 * (forces.TipPin() + 1);  // some 50 roundings at least 0.02 from a division by zero
    EXPECT_NEAR(forces.actuator_n, linkage::ActuatorForce(transmission, torque_nm), rounding_n)
        << testing::TextOf(links) << " d " << pose.stroke_mm;

    // What each member does to the pin at its second end; the opposite at its first.
    const Vector2d actuator = forces.actuator_n * (pose.tip - pose.mount) / pose.stroke_mm;
    const Vector2d coupler = forces.coupler_n * (pose.shank_pin - pose.tip) / links.l1;
    const Vector2d bar = forces.bar_n * (pose.tip - pose.thigh_pin) / links.l2;
    EXPECT_NEAR((actuator + bar - coupler).norm(), 0, rounding_n);
    // The shank bears the coupler at S, the knee pin at K and the leg's couple, the torque turned round.
    const Vector2d knee = -coupler;
    EXPECT_NEAR(Moment(pose.shank_pin, coupler), -1000 * torque_nm, 1000 * rounding_n);
    EXPECT_NEAR(knee.norm(), forces.KneePin(), rounding_n);
    // The thigh plate bears the others' ends at K, P and M: no sum, and the torque about any point.
    EXPECT_NEAR((-knee - bar - actuator).norm(), 0, rounding_n);
    EXPECT_NEAR(Moment(pose.thigh_pin, -bar) + Moment(pose.mount, -actuator), 1000 * torque_nm, 1000 * rounding_n);
    EXPECT_NEAR(forces.ThighPin(), bar.norm(), rounding_n);
    EXPECT_NEAR(forces.Mount(), actuator.norm(), rounding_n);
  }
}

TEST(MemberForces, HaveNoBoundAtADeadPoint) {
  // The published design's shortest stroke at which it can be assembled: actuator and bar in line.
  const linkage::Links links{59.081, 68.840, 55.964, 71.849, 118.630, 287.310};
  const double dead_mm = linkage::AssemblyRanges(links).front().lower_mm;
  EXPECT_GT(linkage::MemberForcesOf(linkage::RequirePose(links, dead_mm + 1e-9), 40).Mount(), 1e6);
}

}  // namespace
}  // namespace lake
