// Stresses and buckling by hand.
#include "lake/parts/strength.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace lake {
namespace {

// The check pose of libs/design/linkage/README.md: 72 N m put 1000 N on actuator and coupler, nothing on the bar.
class CheckPose : public ::testing::Test {
 protected:
  CheckPose() {
    const linkage::Links links{60, 72, 60, 72, 72, 240};
    mechanism_ = parts::MakeMechanism(links, linkage::FindUsedRange(links, 200, {}), {});
    const linkage::Pose pose = linkage::RequirePose(links, 240);
    poses_ = {{pose, 36, linkage::MemberForcesOf(pose, 36)}, {pose, 72, linkage::MemberForcesOf(pose, 72)}};
  }

  parts::StrengthCheck Find(std::string_view part, std::string_view check) const {
    for (const parts::StrengthCheck& found : parts::CheckStrength(mechanism_, poses_))
      if (found.part == part && found.check == check) return found;
    ADD_FAILURE() << "no check " << check << " of " << part;
    return {};
  }

  parts::Mechanism mechanism_;
  std::vector<parts::LoadedPose> poses_;
};

TEST_F(CheckPose, StressesByHand) {
  EXPECT_NEAR(*Find("coupler", "bearing at R and S").stress_mpa, 1000.0 / (8 * 4), 1e-9);
  EXPECT_NEAR(*Find("coupler", "net section").stress_mpa, 1000.0 / ((24 - 8.1) * 4), 1e-9);
  EXPECT_NEAR(Find("coupler", "net section").Safety(), 240 * (24 - 8.1) * 4 / 1000, 1e-9);  // 6061-T6
  EXPECT_NEAR(*Find("thigh plate", "bearing at M").stress_mpa, 1000.0 / 32, 1e-9);
  const double second_moment = 4 * (24 * 24 * 24 - 8.1 * 8.1 * 8.1) / 12;
  EXPECT_NEAR(*Find("shank link", "bending at S").stress_mpa, 72000 * 12 / second_moment, 1e-9);
  EXPECT_NEAR(Find("shank link", "bending at S").load, 72, 1e-12);  // the worse of the two poses
}

// A steel rod of 10 mm, pinned, 240 mm long: pi^2 210 GPa x 490.87 mm^4 / (240 mm)^2.
TEST_F(CheckPose, EulersLoadByHand) {
  const parts::StrengthCheck rod = Find("actuator", "buckling of the rod");
  EXPECT_NEAR(rod.allowed, M_PI * M_PI * 210000 * 490.8739 / (240 * 240), 0.1);
  EXPECT_NEAR(rod.load, 1000, 1e-9);
  EXPECT_FALSE(rod.stress_mpa);
}

TEST_F(CheckPose, ARodThatPullsDoesNotBuckle) {
  for (parts::LoadedPose& pose : poses_) pose.forces = linkage::MemberForcesOf(pose.pose, -pose.knee_torque_nm);
  for (const parts::StrengthCheck& check : parts::CheckStrength(mechanism_, poses_)) EXPECT_NE(check.part, "actuator");
}

// In a wide bar the pins bear least, in a narrow one the section beside the holes.
TEST(Capacity, IsThatOfTheWeakestCheck) {
  const linkage::Links links{60, 72, 60, 72, 72, 240};
  const linkage::Pose pose = linkage::RequirePose(links, 240);
  const parts::LoadedPose loaded{pose, 50, {.actuator_n = 300, .coupler_n = 500, .bar_n = 400}};
  for (const double width_mm : {24.0, 14.0}) {
    parts::PartOptions options;
    options.bar_width_mm = width_mm;
    const parts::Capacity capacity = parts::CapacityOf(options);
    const std::pair<const char*, double> expected[] = {{"coupler", capacity.coupler_n / 500},
                                                       {"bar", capacity.bar_n / 400},
                                                       {"actuator", capacity.rod_nmm2 / (240.0 * 240) / 300}};
    const std::vector<parts::StrengthCheck> checks = parts::CheckStrength(
        parts::MakeMechanism(links, linkage::FindUsedRange(links, 200, {}), options), {&loaded, 1});
    for (const auto& [part, safety] : expected) {
      double least = INFINITY;
      for (const parts::StrengthCheck& check : checks)
        if (check.part == part) least = std::min(least, check.Safety());
      EXPECT_NEAR(safety, least, 1e-9 * least) << part << ", " << width_mm << " mm wide";
    }
    for (const parts::StrengthCheck& check : checks) {
      if (check.check == "bearing at M") {
        EXPECT_NEAR(check.allowed, capacity.actuator_n, 1e-9);
      }
      if (check.check == "bending at S") {
        EXPECT_NEAR(check.allowed, capacity.knee_torque_nm, 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace lake
