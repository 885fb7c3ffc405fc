#include "lake/cuffs/leg_statics.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lake/core/numbers.h"
#include "segment_axes.h"

namespace lake::cuffs {
namespace {

using Eigen::Matrix2d, Eigen::Matrix4d, Eigen::Vector2d, Eigen::Vector4d;

// Small movements of the device: how far its hinge moves (leg frame), and how far each link's turn forward carries what
// is one reach above the hinge.
constexpr int kThighTurn = 2, kShankTurn = 3;

struct HeldLink {
  Matrix2d axes;
  int turn;
  double side;  // +1: above the knee
  double reach_mm;
  const std::vector<Cuff>& cuffs;
  double weight_n;

  // How far a point of the link moves, across and along its segment, per movement.
  Eigen::Matrix<double, 2, 4> MovementAt(double from_knee_mm) const {
    Eigen::Matrix<double, 2, 4> movement = Eigen::Matrix<double, 2, 4>::Zero();
    movement.leftCols<2>() = axes.transpose();
    movement(0, turn) = side * from_knee_mm / reach_mm;
    return movement;
  }

  double CentreOfMass() const { return std::ranges::max(cuffs, {}, &Cuff::from_knee_mm).from_knee_mm / 2; }

  // What a cuff's length adds to its stiffness in turning, per N/mm.
  double LengthStiffness(const Cuff& cuff) const {
    return cuff.length_mm * cuff.length_mm / (12 * reach_mm * reach_mm);
  }
};

std::array<HeldLink, 2> HeldLinks(const Posture& posture, const CuffOptions& o) {
  double reach_mm = 0;
  for (const PlacedCuff& cuff : CuffsOf(o)) reach_mm = std::max(reach_mm, cuff.from_knee_mm);
  return {
      HeldLink{AxesOf(posture.thigh_deg), kThighTurn, 1, reach_mm, o.thigh, o.thigh_link_kg * kGravity_m_s2},
      HeldLink{AxesOf(posture.shank_deg), kShankTurn, -1, reach_mm, o.shank, o.shank_link_kg * kGravity_m_s2},
  };
}

// Where the cuffs, each of 1 N/mm, come to rest; NaN where they do not.
Vector4d MovementTo(const std::array<HeldLink, 2>& links, double moment_nm) {
  Matrix4d stiffness = Matrix4d::Zero();
  Vector4d load = Vector4d::Zero();
  for (const HeldLink& link : links) {
    for (const Cuff& cuff : link.cuffs) {
      const auto movement = link.MovementAt(cuff.from_knee_mm);
      stiffness += movement.transpose() * movement;
      stiffness(link.turn, link.turn) += link.LengthStiffness(cuff);
    }
    const Vector2d weight_n = link.axes.transpose() * Vector2d(0, -link.weight_n);
    load += link.MovementAt(link.CentreOfMass()).transpose() * weight_n;
    load[link.turn] += link.side * moment_nm * kMmPerM / link.reach_mm;  // extension: the thigh's forward
  }
  constexpr double kRounding = 1e-12;
  Eigen::CompleteOrthogonalDecomposition<Matrix4d> held;
  held.setThreshold(kRounding);
  held.compute(stiffness);
  Vector4d movement = held.solve(load);
  constexpr double kUnbalanced = 1e-9;  // of the load; rounding leaves far less where there is a balance
  if ((stiffness * movement - load).norm() <= kUnbalanced * load.norm()) return movement;
  return Vector4d::Constant(std::numeric_limits<double>::quiet_NaN());
}

// Pressure along a cuff is a straight line. Where its couple turns it over, each end presses another way: the larger.
double PressingForce(double across_n, double couple_n_mm, double length_mm) {
  const double force_n = std::abs(across_n), couple = std::abs(couple_n_mm);
  if (6 * couple <= force_n * length_mm) return force_n;
  const double pressing = 0.5 + force_n * length_mm / (12 * couple);  // part of the length
  return 6 * couple / length_mm * pressing * pressing;
}

CuffReaction ReactionOf(const Cuff& cuff, const HeldLink& link, const Vector4d& movement) {
  const double couple_n_mm = link.LengthStiffness(cuff) * movement[link.turn] * link.reach_mm;
  CuffReaction reaction{.force_n = link.MovementAt(cuff.from_knee_mm) * movement, .moment_nm = couple_n_mm / kMmPerM};
  reaction.pressed_n =
      std::hypot(PressingForce(reaction.force_n.x(), couple_n_mm, cuff.length_mm), reaction.force_n.y());
  return reaction;
}

}  // namespace

LegStatics StaticsOf(const Posture& posture, double moment_nm, const CuffOptions& cuffs) {
  CheckCuffs(cuffs);
  const std::array<HeldLink, 2> links = HeldLinks(posture, cuffs);
  const Vector4d movement = MovementTo(links, moment_nm);
  LegStatics statics;
  // The sum of their forces, in the leg frame.
  const auto react = [&](const HeldLink& link, std::vector<CuffReaction>& reactions, double& largest_n) {
    Vector2d sum_n = Vector2d::Zero();
    for (const Cuff& cuff : link.cuffs) {
      reactions.push_back(ReactionOf(cuff, link, movement));
      largest_n = LargerOrNaN(largest_n, reactions.back().pressed_n);
      sum_n += link.axes * reactions.back().force_n;
    }
    return sum_n;
  };
  const Vector2d on_thigh_n = react(links[0], statics.thigh, statics.largest_thigh_n);
  react(links[1], statics.shank, statics.largest_shank_n);
  const Vector2d on_shank_n = links[1].axes.transpose() * on_thigh_n;
  statics.knee_shear_n = std::abs(on_shank_n.x());
  statics.knee_compression_n = -on_shank_n.y();
  return statics;
}

}  // namespace lake::cuffs
