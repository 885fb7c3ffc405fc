// The forces in the mechanism's members against MuJoCo: links that are joined by hinges and cut open at S stay at rest
// under them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "lake/linkage/linkage.h"
#include "model/mujoco_model.h"
#include "temporary_folder.h"

namespace lake {
namespace {

#ifdef LAKE_HAS_MUJOCO

using Eigen::Vector2d;

// Bar, coupler and shank as they stand in a pose, in mm, all joints at zero.
std::string ChainOf(const linkage::Pose& pose) {
  const auto body = [](const char* name, const Vector2d& at, const std::string& rest) {
    return fmt::format(
        "<body name='{}' pos='{:.17g} {:.17g} 0'><joint type='hinge' axis='0 0 1'/>"
        "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>{}</body>",
        name, at.x(), at.y(), rest);
  };
  return "<mujoco><option gravity='0 0 0'/><worldbody>" +
         body("bar", pose.thigh_pin, body("coupler", pose.tip - pose.thigh_pin, "")) + body("shank", pose.knee, "") +
         "</worldbody></mujoco>";
}

// What a force in the plane at a point of a body, and a torque, do to the three joints.
void Apply(testing::MujocoModel& chain, const char* body, const Vector2d& force, const Vector2d& at, double torque,
           std::array<double, 3>& sum) {
  const mjtNum force_n[3] = {force.x(), force.y(), 0}, torque_nmm[3] = {0, 0, torque}, point[3] = {at.x(), at.y(), 0};
  mj_applyFT(chain.Model(), chain.Data(), force_n, torque_nmm, point, chain.Id(mjOBJ_BODY, body), sum.data());
}

// 1e-6 of the torque: Jacobians of a chain some 100 mm long are exact to rounding, and forces stay below 1e4 times it.
TEST(Statics, MembersHoldTheMechanismAtRestInMujoco) {
  const linkage::Links links{59.081, 68.840, 55.964, 71.849, 118.630, 287.310};
  constexpr double kTorque_nm = 40, kTorque_nmm = 1000 * kTorque_nm;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> stroke_mm(245, 374);
  const TemporaryFolder folder;
  for (int i = 0; i < 50; ++i) {
    const linkage::Pose pose = linkage::RequirePose(links, stroke_mm(random));
    std::ofstream(folder / "chain.xml") << ChainOf(pose);
    testing::MujocoModel chain(folder / "chain.xml");
    mj_forward(chain.Model(), chain.Data());
    const linkage::MemberForces forces = linkage::MemberForcesOf(pose, kTorque_nm);
    const Vector2d coupler = forces.coupler_n * (pose.shank_pin - pose.tip).normalized();
    const Vector2d actuator = forces.actuator_n * (pose.tip - pose.mount).normalized();
    std::array<double, 3> joints{};
    Apply(chain, "shank", coupler, pose.shank_pin, kTorque_nmm, joints);  // the load flexes: anticlockwise
    Apply(chain, "coupler", -coupler, pose.shank_pin, 0, joints);
    Apply(chain, "bar", actuator, pose.tip, 0, joints);
    for (const double joint : joints) EXPECT_NEAR(joint, 0, 1e-6 * kTorque_nmm) << pose.stroke_mm;
    // A force that is off by a thousandth would be seen.
    std::array<double, 3> off{};
    Apply(chain, "bar", 1e-3 * actuator, pose.tip, 0, off);
    EXPECT_GT(std::abs(off[0]), 1e-5 * kTorque_nmm);
  }
}

#else

TEST(Statics, MembersHoldTheMechanismAtRestInMujoco) {
  GTEST_SKIP() << "MuJoCo is not installed";
}

#endif

}  // namespace
}  // namespace lake
