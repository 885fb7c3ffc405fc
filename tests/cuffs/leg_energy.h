// The reference of the cuffs' forces, for any hinge: rigid links, joined by a hinge that turns freely or is held, each
// held to its segment by cuffs that yield in proportion to their slip. Sagittal plane, quasi-static.
//
//   energy = ½ Σ slipᵀ K slip − moment · turn − weights · movement,   least over the pose of both links
//
// by Newton's method over the four unknowns of that pose.
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/numbers.h"
#include "lake/cuffs/cuff_model.h"

namespace lake::cuffs {

// Stiffness of cuff and flesh, N/mm, across the segment (compression) and along it (shear).
struct Stiffness {
  double across_n_mm = 1.5, along_n_mm = 1.5;
};

// The leg and what the device does at an instant. Angles from the vertical, positive when the upper end leans forward.
struct LegState {
  double thigh_deg = 0, shank_deg = 0;
  // Where the hinge is against the knee while its links have not moved: in the thigh's and in the shank's frame, mm
  // (x anterior, y along the segment, up). The two are one point at standing; as the knee bends they come apart.
  Eigen::Vector2d hinge_on_thigh_mm = Eigen::Vector2d::Zero(), hinge_on_shank_mm = Eigen::Vector2d::Zero();
  double moment_nm = 0;  // the actuator's, extending the knee; of a hinge that is free to turn
  // The hinge's angle less the knee's where the actuator holds it, as a stroke does: the moment is then what that
  // takes.
  std::optional<double> held_error_deg = {};
};

// On the leg.
struct CuffLoad {
  Eigen::Vector2d slip_mm = Eigen::Vector2d::Zero();  // of the cuff on the segment: across (anterior), along (up)
  Eigen::Vector2d force_n = Eigen::Vector2d::Zero();  // the cuff's on the segment, the same axes
  double moment_nm = 0;
};

struct LegLoad {
  std::vector<CuffLoad> thigh, shank;
  double largest_thigh_n = 0, largest_shank_n = 0;  // of the cuffs
  double knee_shear_n = 0;  // what the knee must pass on across the shank, of all that the cuffs do to the shank
};

namespace energy {

using Eigen::Matrix2d, Eigen::Vector2d;

inline constexpr double kGravity_m_s2 = 9.80665;

// Columns: across the segment (anterior) and along it (up), in the leg frame.
inline Matrix2d AxesOf(double lean_deg) {
  const double lean = RadiansFromDegrees(lean_deg);
  Matrix2d axes;
  axes << std::cos(lean), std::sin(lean), -std::sin(lean), std::cos(lean);
  return axes;
}

// Unknowns: how far the hinge moves from where it would be on the shank (leg frame, mm), and how far the thigh's and
// the shank's link turn against their segments (rad, forward).
constexpr int kUnknowns = 4;
using Vector = Eigen::Matrix<double, kUnknowns, 1>;
using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using SlipRows = Eigen::Matrix<double, 2, kUnknowns>;

// A turn forward moves what is above forward, and what is in front down.
inline Matrix2d TurnForward(double rad) {
  return AxesOf(DegreesFromRadians(rad));
}

struct Link {
  Matrix2d axes;
  int turn;            // which unknown is its turn
  double side;         // +1: above the knee
  Vector2d hinge_mm;   // against the knee, in the segment's axes
  Vector2d offset_mm;  // how far its hinge is from the shank's before the links move, in the leg frame
  double mass_kg;
  const std::vector<Cuff>& cuffs;

  // In the segment's axes.
  Vector2d FromHinge(const Cuff& cuff) const { return Vector2d(0, side * cuff.from_knee_mm) - hinge_mm; }

  // Half way from the hinge to the outermost cuff.
  Vector2d CentreOfMass() const { return FromHinge(*std::ranges::max_element(cuffs, {}, &Cuff::from_knee_mm)) / 2; }
};

// How a point of a link moves against its segment, in the leg frame: how far, per unknown, and twice per turn.
struct Movement {
  Vector2d mm;
  SlipRows per_unknown;
  Vector2d per_turn_turn;
};

inline Movement MovementOf(const Link& link, const Vector2d& from_hinge_mm, const Vector& pose) {
  const Vector2d from_hinge = link.axes * from_hinge_mm, turned = TurnForward(pose[link.turn]) * from_hinge;
  Movement movement{pose.head<2>() + link.offset_mm + turned - from_hinge, SlipRows::Zero(), -turned};
  movement.per_unknown.leftCols<2>().setIdentity();
  movement.per_unknown.col(link.turn) = Vector2d(turned.y(), -turned.x());
  return movement;
}

// At a pose, with its derivatives.
struct Energy {
  double n_mm = 0;
  Vector gradient = Vector::Zero();
  Matrix hessian = Matrix::Zero();
  Matrix without_turns = Matrix::Zero();  // the Hessian of movements that are linear in the turns: never negative

  // What yields by `movement` against these forces per mm.
  void AddSpring(const Movement& movement, const Matrix2d& stiffness, int turn) {
    const Vector2d force = stiffness * movement.mm;
    n_mm += movement.mm.dot(force) / 2;
    gradient += movement.per_unknown.transpose() * force;
    const Matrix linear = movement.per_unknown.transpose() * stiffness * movement.per_unknown;
    without_turns += linear;
    hessian += linear;
    hessian(turn, turn) += movement.per_turn_turn.dot(force);
  }

  void AddWeight(const Movement& movement, double weight_n, int turn) {
    n_mm += movement.mm.y() * weight_n;
    gradient += movement.per_unknown.row(1).transpose() * weight_n;
    hessian(turn, turn) += movement.per_turn_turn.y() * weight_n;
  }

  void AddTurn(double stiffness_n_mm, double rad, int turn) {
    n_mm += stiffness_n_mm * rad * rad / 2;
    gradient[turn] += stiffness_n_mm * rad;
    hessian(turn, turn) += stiffness_n_mm;
    without_turns(turn, turn) += stiffness_n_mm;
  }

  void AddMoment(double moment_n_mm, double rad, int turn) {
    n_mm -= moment_n_mm * rad;
    gradient[turn] -= moment_n_mm;
  }
};

// Of a cuff, N mm per rad.
inline double TurnStiffness(const Cuff& cuff, const Stiffness& stiffness) {
  return stiffness.across_n_mm * cuff.length_mm * cuff.length_mm / 12;
}

inline Energy EnergyAt(const Vector& pose, const std::array<Link, 2>& links, const Stiffness& stiffness,
                       double moment_nm) {
  const Vector2d springs(stiffness.across_n_mm, stiffness.along_n_mm);
  Energy energy;
  for (const Link& link : links) {
    const Matrix2d in_leg = link.axes * springs.asDiagonal() * link.axes.transpose();
    for (const Cuff& cuff : link.cuffs) {
      energy.AddSpring(MovementOf(link, link.FromHinge(cuff), pose), in_leg, link.turn);
      energy.AddTurn(TurnStiffness(cuff, stiffness), pose[link.turn], link.turn);
    }
    energy.AddWeight(MovementOf(link, link.CentreOfMass(), pose), link.mass_kg * kGravity_m_s2, link.turn);
    // Extension: the thigh's link turns forward, the shank's back.
    energy.AddMoment(link.side * moment_nm * kMmPerM, pose[link.turn], link.turn);
  }
  return energy;
}

// The pose of least energy, by Newton's method; where the hinge is held, among those in which the shank's link turns by
// `held_rad` more than the thigh's.
inline Vector PoseOf(const std::function<Energy(const Vector&)>& energy_at, const std::optional<double>& held_rad) {
  Eigen::Matrix<double, kUnknowns, Eigen::Dynamic, 0, kUnknowns, kUnknowns> free = Matrix::Identity();
  Vector pose = Vector::Zero();
  if (held_rad) {
    free.conservativeResize(Eigen::NoChange, 3);
    free(3, 2) = 1;
    pose[3] = *held_rad;
  }
  constexpr int kMostSteps = 100;
  constexpr double kSmall = 1e-11;     // mm, rad
  constexpr double kRounding = 1e-12;  // of an energy
  for (int i = 0; i < kMostSteps; ++i) {
    const Energy energy = energy_at(pose);
    const Eigen::LLT<Eigen::MatrixXd> newton(free.transpose() * energy.hessian * free);
    const Eigen::LDLT<Eigen::MatrixXd> linear(free.transpose() * energy.without_turns * free);
    const Eigen::VectorXd downhill = -free.transpose() * energy.gradient;
    const Eigen::VectorXd down =
        newton.info() == Eigen::Success ? newton.solve(downhill).eval() : linear.solve(downhill).eval();
    const Vector step = free * down;
    if (!(step.norm() > kSmall)) break;  // also where the misfit is unknown
    double part = 1;
    const double most_n_mm = energy.n_mm + kRounding * (1 + std::abs(energy.n_mm));
    while (part > kSmall && energy_at(pose + part * step).n_mm > most_n_mm) part /= 2;
    pose += part * step;
  }
  return pose;
}

}  // namespace energy

inline LegLoad LoadOnLeg(const LegState& leg, const CuffOptions& options, const Stiffness& stiffness) {
  using namespace energy;
  CheckCuffs(options);
  const Vector2d misfit_mm = MisfitOf(leg.hinge_on_shank_mm, leg.hinge_on_thigh_mm, leg.thigh_deg, leg.shank_deg);
  const std::array<Link, 2> links = {
      Link{AxesOf(leg.thigh_deg), 2, 1, leg.hinge_on_thigh_mm, -misfit_mm, options.thigh_link_kg, options.thigh},
      Link{AxesOf(leg.shank_deg), 3, -1, leg.hinge_on_shank_mm, Vector2d::Zero(), options.shank_link_kg,
           options.shank}};
  const auto energy_at = [&](const Vector& pose) { return EnergyAt(pose, links, stiffness, leg.moment_nm); };
  const std::optional<double> held_rad =
      leg.held_error_deg ? std::optional(RadiansFromDegrees(*leg.held_error_deg)) : std::nullopt;
  const Vector pose = PoseOf(energy_at, held_rad);
  LegLoad load;
  Vector2d on_shank = Vector2d::Zero();
  for (const Link& link : links)
    for (const Cuff& cuff : link.cuffs) {
      CuffLoad one;
      one.slip_mm = link.axes.transpose() * MovementOf(link, link.FromHinge(cuff), pose).mm;
      one.force_n = Vector2d(stiffness.across_n_mm, stiffness.along_n_mm).cwiseProduct(one.slip_mm);
      one.moment_nm = TurnStiffness(cuff, stiffness) * pose[link.turn] / kMmPerM;
      double& largest_n = link.side > 0 ? load.largest_thigh_n : load.largest_shank_n;
      largest_n = LargerOrNaN(largest_n, one.force_n.norm());
      if (link.side < 0) on_shank += one.force_n;
      (link.side > 0 ? load.thigh : load.shank).push_back(one);
    }
  load.knee_shear_n = std::abs(on_shank.x());
  return load;
}

}  // namespace lake::cuffs
