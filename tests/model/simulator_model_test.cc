// The models for simulators, simulated: MuJoCo against the closed form.
#include "lake/model/simulator_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "lake/core/angles.h"
#include "model/mujoco_model.h"
#include "temporary_folder.h"

namespace lake {
namespace {

constexpr linkage::Links kDesigns[] = {{59.081, 68.840, 55.964, 71.849, 118.630, 287.310},  // the published one
                                       {60, 70, 55, 72, 70, 240},
                                       {65, 70, 58, 75, 90, 250}};
constexpr double kShortest_mm[] = {245, 205, 200};

parts::Mechanism DesignNumber(int number) {
  const linkage::Links& links = kDesigns[number];
  return parts::MakeMechanism(links, linkage::FindUsedRange(links, kShortest_mm[number], {}), {});
}

#ifdef LAKE_HAS_MUJOCO

testing::MujocoModel Weightless(const parts::Mechanism& mechanism) {
  const TemporaryFolder folder;
  model::WriteMjcf(folder / "design.xml", mechanism);
  testing::MujocoModel simulation(folder / "design.xml");
  mju_zero(simulation.Model()->opt.gravity, 3);
  return simulation;
}

// The stroke is commanded over its range without load or gravity; what the loops then make of the knee is the closed
// form's angle. 0.01 degrees: MuJoCo's loops yield to forces and inertia.
TEST(Mjcf, KneeFollowsTheStrokeAsInClosedForm) {
  for (int number = 0; number < 3; ++number) {
    const parts::Mechanism mechanism = DesignNumber(number);
    testing::MujocoModel simulation = Weightless(mechanism);
    for (const double part : {0.5, 0.8, 0.95, 0.3, 0.05}) {
      const double stroke_mm = mechanism.range.stroke.lower_mm + part * mechanism.range.stroke.Travel();
      simulation.MoveTo(1e-3 * stroke_mm);
      EXPECT_NEAR(1e3 * simulation.Position("stroke"), stroke_mm, 0.01);
      const linkage::Pose pose = linkage::RequirePose(mechanism.links, 1e3 * simulation.Position("stroke"));
      EXPECT_NEAR(DegreesFromRadians(simulation.Position("knee")), DegreesFromRadians(pose.theta_rad), 0.01)
          << "design " << number << " at " << stroke_mm;
    }
  }
}

// 40 N m flex the knee; the actuator holds. Force and angle at the stroke to which the servo yields.
TEST(Mjcf, ActuatorBearsAKneeTorqueAsInClosedForm) {
  for (int number = 0; number < 3; ++number) {
    const parts::Mechanism mechanism = DesignNumber(number);
    testing::MujocoModel simulation = Weightless(mechanism);
    simulation.AppliedForce("knee") = 40;
    for (const double part : {0.5, 0.8, 0.25}) {
      simulation.MoveTo(1e-3 * (mechanism.range.stroke.lower_mm + part * mechanism.range.stroke.Travel()));
      const linkage::Pose pose = linkage::RequirePose(mechanism.links, 1e3 * simulation.Position("stroke"));
      const double force_n = linkage::ActuatorForce(linkage::TransmissionOf(mechanism.links, pose), 40);
      EXPECT_NEAR(simulation.Data()->actuator_force[0], force_n, 0.01 * force_n) << "design " << number;
      EXPECT_NEAR(DegreesFromRadians(simulation.Position("knee")), DegreesFromRadians(pose.theta_rad), 0.01);
    }
  }
}

TEST(Mjcf, BodiesHaveTheMassAndInertiaOfTheirParts) {
  const TemporaryFolder folder;
  const parts::Mechanism mechanism = DesignNumber(0);
  model::WriteMjcf(folder / "design.xml", mechanism);
  testing::MujocoModel simulation(folder / "design.xml");
  mj_forward(simulation.Model(), simulation.Data());
  const char* const kNames[] = {"thigh_plate", "shank_link", "coupler", "slewing_bar"};
  for (std::size_t i = 0; i < parts::kPlates; ++i) {
    const int body = simulation.Id(mjOBJ_BODY, kNames[i]);
    const parts::PlateMass mass = parts::MassOf(mechanism.plates[i]);
    EXPECT_NEAR(simulation.Model()->body_mass[body], mass.mass_kg, 1e-12);
    const double* inertia = simulation.Model()->body_inertia + 3 * body;
    EXPECT_NEAR(inertia[0] + inertia[1] + inertia[2], 1e-6 * (mass.xx_kg_mm2 + mass.yy_kg_mm2 + mass.zz_kg_mm2), 1e-12);
    // In the model's frame: x forward, z up.
    const parts::Placement thigh_from_part =
        parts::PlacementOf(static_cast<parts::Body>(i), model::ReferencePose(mechanism));
    const Eigen::Vector2d centre = thigh_from_part * mass.centre_mm;
    const double* at = simulation.Data()->xipos + 3 * body;
    EXPECT_NEAR(1e3 * at[0], -centre.x(), 1e-9);
    EXPECT_NEAR(1e3 * at[2], centre.y(), 1e-9);
  }
}

// With the joints where the closed form has them, the two cuts of the tree meet.
TEST(Urdf, LoopsCloseAtTheClosedFormsJointPositions) {
  const TemporaryFolder folder;
  for (int number = 0; number < 3; ++number) {
    const parts::Mechanism mechanism = DesignNumber(number);
    model::WriteUrdf(folder / "design.urdf", mechanism);
    testing::MujocoModel simulation(folder / "design.urdf");
    for (const double part : {0.1, 0.6, 0.9}) {
      const linkage::Pose pose = linkage::RequirePose(
          mechanism.links, mechanism.range.stroke.lower_mm + part * mechanism.range.stroke.Travel());
      const auto turn = [&](parts::Body body) { return parts::PlacementOf(body, pose).turn_rad; };
      simulation.Position("knee") = pose.theta_rad;
      simulation.Position("thigh_pin") = turn(parts::Body::kBar);
      simulation.Position("tip") = turn(parts::Body::kCoupler) - turn(parts::Body::kBar);
      simulation.Position("mount") = turn(parts::Body::kActuator);
      simulation.Position("stroke") = 1e-3 * pose.stroke_mm;
      mj_kinematics(simulation.Model(), simulation.Data());
      const auto place = [&](const char* body, double x_mm) {
        const int id = simulation.Id(mjOBJ_BODY, body);
        const double in_body[3] = {1e-3 * x_mm, 0, 0};
        Eigen::Vector3d at;
        mju_rotVecMat(at.data(), in_body, simulation.Data()->xmat + 9 * id);
        return Eigen::Vector3d(at + Eigen::Map<Eigen::Vector3d>(simulation.Data()->xpos + 3 * id));
      };
      const linkage::Links& links = mechanism.links;
      EXPECT_NEAR((place("coupler", links.l1) - place("shank_link", links.l4)).norm(), 0, 1e-12);
      EXPECT_NEAR((place("actuator_rod", 0) - place("slewing_bar", links.l2)).norm(), 0, 1e-12);
      const Eigen::Vector3d shank_pin(-1e-3 * pose.shank_pin.x(), 0, 1e-3 * pose.shank_pin.y());
      EXPECT_NEAR((place("shank_link", links.l4) - shank_pin).norm(), 0, 1e-12);
    }
    EXPECT_NEAR(simulation.Model()->body_mass[simulation.Id(mjOBJ_BODY, "shank_link")],
                parts::MassOf(mechanism.plates[1]).mass_kg, 1e-12);
  }
}

#else

TEST(Mjcf, IsSimulated) {
  GTEST_SKIP() << "MuJoCo is not installed";
}

#endif

}  // namespace
}  // namespace lake
