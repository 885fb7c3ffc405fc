// The mechanism on a leg, simulated: MuJoCo against the cuffs' model, the body's masses and the mechanism's loops.
#include "lake/model/coupled_model.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "cuffs/leg_energy.h"
#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/linkage/linkage.h"
#include "model/mujoco_model.h"
#include "model/worn_person.h"
#include "temporary_folder.h"

namespace lake {
namespace {

TEST(CoupledModel, RefusesWhatIsNoCuff) {
  const TemporaryFolder folder;
  const parts::Mechanism mechanism = testing::Published();
  model::Subject subject = testing::Wearing(mechanism);
  subject.cuffs.shank.clear();
  EXPECT_THROW(model::WriteCoupledMjcf(folder / "design.xml", mechanism, subject), UsageError);
}

TEST(CoupledModel, ItsCourseIsTheRise) {
  const TemporaryFolder folder;
  const model::Subject subject = testing::Wearing(testing::Published());
  model::WriteCourse(folder / "course.csv", subject);
  const CsvTable table = CsvTable::Read(folder / "course.csv");
  ASSERT_EQ(table.Rows(), 101u);
  const auto at = [&](std::size_t row, const char* column) { return table.RequiredNumber(row, table.Column(column)); };
  EXPECT_EQ(at(100, "time_s"), 6);
  EXPECT_EQ(at(50, "human_knee_deg"), subject.rise[50].knee_deg);
  // Shank, less the knee, and the hip on top make the trunk's lean.
  EXPECT_NEAR(at(50, "ankle_deg") - at(50, "human_knee_deg") + at(50, "hip_deg"), subject.rise[50].trunk_deg, 1e-9);
}

#ifdef LAKE_HAS_MUJOCO

class Worn : public ::testing::Test {
 protected:
  Worn() { Wear(testing::Wearing(mechanism_)); }

  void Wear(const model::Subject& subject) {
    subject_ = subject;
    const TemporaryFolder folder;
    model::WriteCoupledMjcf(folder / "design.xml", mechanism_, subject_);
    simulation_ = std::make_unique<testing::MujocoModel>(folder / "design.xml");
    mj_forward(simulation_->Model(), simulation_->Data());
    pin_in_shank_ = Local("shank_link", CouplerEnd());
    tip_in_bar_ = Local("slewing_bar", At("actuator_rod", {0, 0, 0}));
  }

  using Point = std::array<double, 3>;
  int Body(const char* name) { return simulation_->Id(mjOBJ_BODY, name); }
  Point At(const char* body, const Point& local) {
    Point world{};
    mju_rotVecMat(world.data(), local.data(), simulation_->Data()->xmat + 9 * Body(body));
    mju_addTo3(world.data(), simulation_->Data()->xpos + 3 * Body(body));
    return world;
  }
  Point Local(const char* body, const Point& world) {
    Point from{}, local{};
    mju_sub3(from.data(), world.data(), simulation_->Data()->xpos + 3 * Body(body));
    mju_rotVecMatT(local.data(), from.data(), simulation_->Data()->xmat + 9 * Body(body));
    return local;
  }
  Point CouplerEnd() { return At("coupler", {1e-3 * mechanism_.links.l1, 0, 0}); }
  static double ApartMm(const Point& a, const Point& b) { return 1e3 * mju_dist3(a.data(), b.data()); }
  double LoopsApartMm() {
    return std::max(ApartMm(CouplerEnd(), At("shank_link", pin_in_shank_)),
                    ApartMm(At("actuator_rod", {0, 0, 0}), At("slewing_bar", tip_in_bar_)));
  }

  static std::array<double, 4> ControlOf(const model::WornSample& s) {
    return {RadiansFromDegrees(s.shank_deg), RadiansFromDegrees(s.knee_deg),
            RadiansFromDegrees(s.trunk_deg - s.shank_deg + s.knee_deg), 1e-3 * s.stroke_mm};
  }

  // From where the controls are, in so many seconds.
  void Ramp(const std::array<double, 4>& to, double seconds) {
    mjData* data = simulation_->Data();
    const int steps = static_cast<int>(seconds / simulation_->Model()->opt.timestep);
    std::array<double, 4> from{};
    std::copy_n(data->ctrl, 4, from.begin());
    for (int step = 1; step <= steps; ++step) {
      for (std::size_t k = 0; k < 4; ++k) data->ctrl[k] = std::lerp(from[k], to[k], static_cast<double>(step) / steps);
      mj_step(simulation_->Model(), data);
    }
  }

  void StartInReference() {
    const char* joints[] = {"ankle", "human_knee", "hip", "stroke"};
    for (int k = 0; k < 4; ++k) simulation_->Data()->ctrl[k] = simulation_->Position(joints[k]);
  }

  // How far the simulated cuffs' forces are from those of their model at the angles that the simulation has, as a share
  // of the largest.
  double OffTheModel() {
    const double stiffness = std::sqrt(subject_.cuffs.softest_n_mm * subject_.cuffs.stiffest_n_mm);
    const double knee_deg = DegreesFromRadians(simulation_->Position("human_knee")),
                 hinge_deg = DegreesFromRadians(simulation_->Position("knee"));
    const Eigen::Vector2d on_thigh =
        cuffs::MisfitOf(Eigen::Vector2d::Zero(), subject_.hinge_mm, subject_.rise.back().knee_deg, 0);
    const cuffs::LegLoad load = cuffs::LoadOnLeg({-knee_deg, 0, on_thigh, subject_.hinge_mm, 0, hinge_deg - knee_deg},
                                                 subject_.cuffs, {stiffness, stiffness});
    double off_n = 0;
    const auto compare = [&](const std::string& pad, const cuffs::CuffLoad& expected) {
      const Eigen::Vector2d force(1e3 * stiffness * simulation_->Position((pad + "_x").c_str()),
                                  1e3 * stiffness * simulation_->Position((pad + "_z").c_str()));
      off_n = std::max(off_n, (force - expected.force_n).norm());
    };
    compare("thigh_cuff_1", load.thigh[0]);
    compare("thigh_cuff_2", load.thigh[1]);
    compare("shank_cuff_1", load.shank[0]);
    return off_n / std::max(load.largest_thigh_n, load.largest_shank_n);
  }

  const parts::Mechanism mechanism_ = testing::Published();
  model::Subject subject_;
  std::unique_ptr<testing::MujocoModel> simulation_;
  Point pin_in_shank_{}, tip_in_bar_{};
};

TEST_F(Worn, TheBodyHasItsMasses) {
  const mjModel& m = *simulation_->Model();
  const loads::LegBody& body = subject_.body.body;
  for (const auto& [name, segment] : {std::pair{"foot", &body.foot}, std::pair{"shank", &body.shank},
                                      std::pair{"thigh", &body.thigh}, std::pair{"trunk", &body.trunk}}) {
    EXPECT_NEAR(m.body_mass[Body(name)], segment->mass_kg, 1e-9) << name;
    EXPECT_NEAR(m.body_inertia[3 * Body(name) + 1], segment->mass_kg * segment->gyration_m * segment->gyration_m, 1e-9);
  }
  // Centres: upright from the ankle, the thigh bent at the reference, the trunk upright.
  const double* shank = simulation_->Data()->xipos + 3 * Body("shank");
  EXPECT_NEAR(shank[2], 0.42 - body.shank.centre_m, 1e-9);
  const double* trunk = simulation_->Data()->xipos + 3 * Body("trunk");
  const double* hip = simulation_->Data()->xpos + 3 * Body("trunk");
  EXPECT_NEAR(trunk[2] - hip[2], 0.32, 1e-6);
  EXPECT_NEAR(trunk[0] - hip[0], 0, 1e-6);
}

// At rest, without weight, the cuffs do what their model says: within 1 %, on the knee and 26 mm off.
TEST_F(Worn, CuffsDoAtRestWhatTheirModelSays) {
  for (const Eigen::Vector2d& hinge_mm : {Eigen::Vector2d(0.35, -0.55), Eigen::Vector2d(14, -22)}) {
    Wear(testing::Wearing(mechanism_, hinge_mm));
    mju_zero(simulation_->Model()->opt.gravity, 3);
    StartInReference();
    for (const std::size_t percent : {70u, 40u, 0u}) {
      Ramp(ControlOf(subject_.rise[percent]), 1.5);
      simulation_->Settle();
      for (const char* joint : {"human_knee", "knee"})
        EXPECT_NEAR(DegreesFromRadians(simulation_->Position(joint)), subject_.rise[percent].knee_deg, 0.02);
      EXPECT_LT(OffTheModel(), 0.01) << hinge_mm.transpose() << " mm at " << percent << " %";
      EXPECT_LT(LoopsApartMm(), 0.01);
    }
  }
}

// With weight, through the whole rise to standing; loops closed throughout.
TEST_F(Worn, RisesToStanding) {
  StartInReference();
  Ramp(ControlOf(subject_.rise.front()), 2);
  double most_mm = 0;
  for (std::size_t i = 1; i < subject_.rise.size(); ++i) {
    Ramp(ControlOf(subject_.rise[i]), subject_.rise[i].time_s - subject_.rise[i - 1].time_s);
    most_mm = std::max(most_mm, LoopsApartMm());
    ASSERT_NEAR(DegreesFromRadians(simulation_->Position("human_knee")), subject_.rise[i].knee_deg, 1) << i << " %";
    ASSERT_NEAR(DegreesFromRadians(simulation_->Position("knee")), subject_.rise[i].knee_deg, 1) << i << " %";
  }
  EXPECT_LT(most_mm, 0.01);
  simulation_->Settle();
  EXPECT_NEAR(DegreesFromRadians(simulation_->Position("human_knee")), subject_.rise.back().knee_deg, 0.1);
  EXPECT_NEAR(simulation_->Data()->xpos[3 * Body("trunk") + 2],
              0.42 * std::cos(RadiansFromDegrees(6)) + 0.4 * std::cos(RadiansFromDegrees(2)), 0.002);
}

// The keyframes have the controls of the rise.
TEST_F(Worn, KeyframesAreTheRise) {
  const mjModel& m = *simulation_->Model();
  ASSERT_EQ(m.nkey, 21);
  const int half = simulation_->Id(mjOBJ_KEY, "50_percent");
  EXPECT_NEAR(m.key_time[half], 3, 1e-12);
  const std::array<double, 4> control = ControlOf(subject_.rise[50]);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(m.key_ctrl[4 * half + k], control[static_cast<std::size_t>(k)], 1e-9);
}

#else
TEST(Worn, IsSimulated) {
  GTEST_SKIP() << "MuJoCo is not installed";
}
#endif

// The forces in the mechanism's members against MuJoCo: links that are joined by hinges and cut open at S stay at rest
// under them.

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
