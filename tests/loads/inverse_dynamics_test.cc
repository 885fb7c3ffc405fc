// Moments of a planar chain against MuJoCo's inverse dynamics, against the balance of energy, and by hand.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <random>

#include "lake/loads/leg_dynamics.h"
#include "temporary_folder.h"

namespace lake::loads {
namespace {

using Eigen::Vector2d;

constexpr double kShank_m = 0.41, kThigh_m = 0.40, kTrunk_m = 0.52;
constexpr double kAlong_m = 0.03, kAcross_m = -0.02;  // the trunk's centre, beside the table's place

LegBody SomeBody() {
  LegBody body;
  body.foot = {1.1, 0.05, 0.07};
  body.shank = {3.1, 0.433 * kShank_m, 0.302 * kShank_m};
  body.thigh = {7.3, 0.42 * kThigh_m, 0.323 * kThigh_m};
  body.trunk = {22.0, 0.62 * kTrunk_m, 0.49 * kTrunk_m};
  body.sole = {0.06, 0.19};
  body.ankle_height_m = 0.07;
  return body;
}

// The segments' tilts, from the vertical and forward: sums of sines.
struct Tilts {
  std::array<std::array<double, 3>, 3> amplitude, rate, phase;

  explicit Tilts(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    for (std::size_t s = 0; s < 3; ++s)
      for (std::size_t k = 0; k < 3; ++k)
        amplitude[s][k] = 0.6 * unit(random), rate[s][k] = 1 + 6 * unit(random), phase[s][k] = 6 * unit(random);
  }

  // Tilt of a segment and its first and second derivative.
  Eigen::Vector3d At(std::size_t segment, double t) const {
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const double w = rate[segment][k], a = amplitude[segment][k], angle = w * t + phase[segment][k];
      value += a * Eigen::Vector3d(std::sin(angle), w * std::cos(angle), -w * w * std::sin(angle));
    }
    return value;
  }
};

PointMotion Beyond(const PointMotion& lower, double length_m, const Eigen::Vector3d& tilt) {
  const Vector2d u(std::sin(tilt[0]), std::cos(tilt[0])), n(u.y(), -u.x());
  return {lower.position_m + length_m * u, lower.velocity_m_s + length_m * tilt[1] * n,
          lower.acceleration_m_s2 + length_m * (tilt[2] * n - tilt[1] * tilt[1] * u)};
}

LegPoints PointsAt(const Tilts& tilts, double t) {
  LegPoints points;
  points[kAnkle].position_m = {0.2, 0.07};
  points[kKnee] = Beyond(points[kAnkle], kShank_m, tilts.At(0, t));
  points[kHip] = Beyond(points[kKnee], kThigh_m, tilts.At(1, t));
  points[kTrunkTop] = Beyond(points[kHip], kTrunk_m, tilts.At(2, t));
  return points;
}

LegLoads LoadsAt(const LegPoints& points) {
  const SegmentMotion trunk = SegmentBetween(points[kHip], points[kTrunkTop]);
  return LoadsFromTrunk(points, SomeBody(), FixedInTrunk(trunk, kAlong_m, kAcross_m));
}

struct MujocoChain {
  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> model{nullptr, &mj_deleteModel};
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data{nullptr, &mj_deleteData};

  MujocoChain() {
    const LegBody body = SomeBody();
    const auto inertial = [](const SegmentInertia& s, double x_m, double z_m) {
      const double inertia = s.mass_kg * s.gyration_m * s.gyration_m;
      return fmt::format("<inertial pos='{:.17g} 0 {:.17g}' mass='{:.17g}' diaginertia='{:.17g} {:.17g} {:.17g}'/>",
                         x_m, z_m, s.mass_kg, inertia, inertia, inertia);
    };
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.Path() / "chain.xml";
    std::ofstream(file) << fmt::format(
        "<mujoco><compiler angle='radian'/><option gravity='0 0 {:.17g}'/><worldbody>"
        "<body pos='0.2 0 0.07'><joint type='hinge' axis='0 1 0'/>{}"
        "<body pos='0 0 {:.17g}'><joint type='hinge' axis='0 1 0'/>{}"
        "<body pos='0 0 {:.17g}'><joint type='hinge' axis='0 1 0'/>{}</body></body></body></worldbody></mujoco>",
        -kGravity_m_s2, inertial(body.shank, 0, kShank_m - body.shank.centre_m), kShank_m,
        inertial(body.thigh, 0, kThigh_m - body.thigh.centre_m), kThigh_m,
        inertial(body.trunk, kAcross_m, body.trunk.centre_m + kAlong_m));
    std::array<char, 500> error = {};
    model.reset(mj_loadXML(file.c_str(), nullptr, error.data(), static_cast<int>(error.size())));
    if (!model) throw std::runtime_error(error.data());
    data.reset(mj_makeData(model.get()));
  }

  JointMoments At(const Tilts& tilts, double t) {
    for (int derivative = 0; derivative < 3; ++derivative) {
      mjtNum* values = derivative == 0 ? data->qpos : derivative == 1 ? data->qvel : data->qacc;
      for (std::size_t s = 0; s < 3; ++s)
        values[s] = tilts.At(s, t)[derivative] - (s > 0 ? tilts.At(s - 1, t)[derivative] : 0);
    }
    mj_inverse(model.get(), data.get());
    // About +y, which leans forward: at ankle and hip that is flexion.
    return {-data->qfrc_inverse[0], data->qfrc_inverse[1], -data->qfrc_inverse[2]};
  }
};

TEST(InverseDynamics, EqualsMujocoOnRandomMotion) {
  MujocoChain chain;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Tilts tilts(seed);
    for (const double t : {0.0, 0.37, 1.1}) {
      const JointMoments expected = chain.At(tilts, t), found = LoadsAt(PointsAt(tilts, t)).moments;
      const double scale = std::abs(expected.ankle_nm) + std::abs(expected.knee_nm) + std::abs(expected.hip_nm);
      EXPECT_NEAR(found.ankle_nm, expected.ankle_nm, 1e-9 * scale) << "seed " << seed;
      EXPECT_NEAR(found.knee_nm, expected.knee_nm, 1e-9 * scale) << "seed " << seed;
      EXPECT_NEAR(found.hip_nm, expected.hip_nm, 1e-9 * scale) << "seed " << seed;
    }
  }
}

// What the joints put in is what the bodies gain.
TEST(InverseDynamics, EnergyIsConserved) {
  const LegBody body = SomeBody();
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Tilts tilts(seed);
    const auto energy_j = [&](double t) {
      const LegPoints points = PointsAt(tilts, t);
      double sum = 0;
      const auto add = [&](const SegmentInertia& s, const Vector2d& centre, const Vector2d& velocity, double turn) {
        sum += s.mass_kg * (velocity.squaredNorm() / 2 + kGravity_m_s2 * centre.y() +
                            s.gyration_m * s.gyration_m * turn * turn / 2);
      };
      const auto on_line = [&](const SegmentInertia& s, Joint lower, Joint upper, double length_m, double turn) {
        const double part = s.centre_m / length_m;
        add(s, points[upper].position_m + part * (points[lower].position_m - points[upper].position_m),
            points[upper].velocity_m_s + part * (points[lower].velocity_m_s - points[upper].velocity_m_s), turn);
      };
      on_line(body.shank, kAnkle, kKnee, kShank_m, tilts.At(0, t)[1]);
      on_line(body.thigh, kKnee, kHip, kThigh_m, tilts.At(1, t)[1]);
      const Eigen::Vector3d tilt = tilts.At(2, t);
      const Vector2d u(std::sin(tilt[0]), std::cos(tilt[0])), n(u.y(), -u.x());
      const double along = body.trunk.centre_m + kAlong_m;
      add(body.trunk, points[kHip].position_m + along * u + kAcross_m * n,
          points[kHip].velocity_m_s + tilt[1] * (along * n - kAcross_m * u), tilt[1]);
      return sum;
    };
    const double t = 0.3, h = 1e-4;
    const JointMoments m = LoadsAt(PointsAt(tilts, t)).moments;
    const double shank = tilts.At(0, t)[1], thigh = tilts.At(1, t)[1], trunk = tilts.At(2, t)[1];
    const double power_w = -m.ankle_nm * shank + m.knee_nm * (thigh - shank) - m.hip_nm * (trunk - thigh);
    // The difference quotient is off by h² of the third derivative, some 1e5 W/s².
    EXPECT_NEAR(power_w, (energy_j(t + h) - energy_j(t - h)) / (2 * h), 1e-6 * std::abs(power_w) + 1e-3);
  }
}

LegPoints AtRest(const Vector2d& ankle, const Vector2d& knee, const Vector2d& hip, const Vector2d& top) {
  LegPoints points;
  points[kAnkle].position_m = ankle;
  points[kKnee].position_m = knee;
  points[kHip].position_m = hip;
  points[kTrunkTop].position_m = top;
  return points;
}

TEST(InverseDynamics, ThighLevelAndTrunkUprightByHand) {
  const LegBody body = SomeBody();
  const LegLoads loads =
      LoadsFromTrunk(AtRest({0, 0.07}, {0, 0.07 + kShank_m}, {-kThigh_m, 0.07 + kShank_m}, {-kThigh_m, 1}), body, {});
  const double trunk_nm = 22.0 * kGravity_m_s2 * kThigh_m,
               thigh_nm = 7.3 * kGravity_m_s2 * (kThigh_m - body.thigh.centre_m);
  EXPECT_NEAR(loads.moments.hip_nm, 0, 1e-12);
  EXPECT_NEAR(loads.moments.knee_nm, trunk_nm + thigh_nm, 1e-9);      // the hip is behind: it extends
  EXPECT_NEAR(loads.moments.ankle_nm, -(trunk_nm + thigh_nm), 1e-9);  // and the ankle dorsiflexes: a fall backward
  const double weight_n = (22.0 + 7.3 + 3.1 + 1.1) * kGravity_m_s2;
  EXPECT_NEAR(loads.ground_force_n.y(), weight_n, 1e-9);
  EXPECT_NEAR(loads.zmp_m, (-trunk_nm - thigh_nm + 1.1 * kGravity_m_s2 * 0.05) / weight_n, 1e-12);
}

TEST(InverseDynamics, ATrunkThatLeansForwardExtendsTheHip) {
  const LegBody body = SomeBody();
  const LegLoads loads = LoadsFromTrunk(AtRest({0, 0.07}, {0, 0.48}, {0, 0.88}, {0.52, 0.88}), body, {});
  const double trunk_nm = 22.0 * kGravity_m_s2 * body.trunk.centre_m;
  EXPECT_NEAR(loads.moments.hip_nm, trunk_nm, 1e-9);
  EXPECT_NEAR(loads.moments.knee_nm, -trunk_nm, 1e-9);  // the knee would overextend
  EXPECT_NEAR(loads.moments.ankle_nm, trunk_nm, 1e-9);  // on the toes: plantar flexion
}

TEST(InverseDynamics, FromTheGroundAndFromTheTrunkAgree) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const LegPoints points = PointsAt(Tilts(seed), 0.2);
    const LegLoads down = LoadsAt(points);
    const Vector2d at = GroundPoint(points, SomeBody()) + Vector2d(down.zmp_m, 0);
    const LegLoads up = LoadsFromGround(points, SomeBody(), About({down.ground_force_n, 0}, at, Vector2d::Zero()));
    EXPECT_NEAR(up.moments.ankle_nm, down.moments.ankle_nm, 1e-9);
    EXPECT_NEAR(up.moments.knee_nm, down.moments.knee_nm, 1e-9);
    EXPECT_NEAR(up.moments.hip_nm, down.moments.hip_nm, 1e-9);
    EXPECT_NEAR(up.zmp_m, down.zmp_m, 1e-12);
  }
}

// The estimate's derivatives against differences.
TEST(InverseDynamics, AChangeOfTheTrunksCentreChangesTheWrenchAsPredicted) {
  const LegPoints points = PointsAt(Tilts(3), 0.2);
  const LegBody body = SomeBody();
  const SegmentMotion motion = SegmentBetween(points[kHip], points[kTrunkTop]);
  const Vector2d about(0.1, 0.2);
  const double h = 1e-6;
  for (const auto& change : {FixedInTrunk(motion, 1, 0), FixedInTrunk(motion, 0, 1), Displacement{{0.3, 0}, {7, 0}}}) {
    const auto wrench = [&](double step) {
      const Body moved = TrunkBody(points, body, {step * change.value_m, step * change.acceleration_m_s2});
      return RequiredWrench(std::span(&moved, 1), about);
    };
    const Wrench expected = WrenchChange(TrunkBody(points, body, {}), change, about);
    EXPECT_NEAR(expected.moment_nm, (wrench(h).moment_nm - wrench(-h).moment_nm) / (2 * h), 1e-5);
    EXPECT_NEAR(expected.force_n.x(), (wrench(h).force_n.x() - wrench(-h).force_n.x()) / (2 * h), 1e-5);
  }
}

}  // namespace
}  // namespace lake::loads
