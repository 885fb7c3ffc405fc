#include "lake/loads/trunk_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/error.h"

namespace lake::loads {
namespace {

using Eigen::MatrixXd, Eigen::Vector2d, Eigen::Vector3d, Eigen::VectorXd;

// With a spline of coefficients of variance 1 the mean variance of its values is 0.48: so much larger the coefficients.
constexpr double kCoefficientsPerValue = 1.44;

Displacement Wobble(const SplineGrid& grid, double time_s, const VectorXd& own) {
  const SplineGrid::Place place = grid.At(time_s);
  const std::span<const double> values(own.data(), grid.count);
  return {{ValueAt(place, values), 0}, {CurveAt(place, values), 0}};
}

Displacement operator+(const Displacement& a, const Displacement& b) {
  return {a.value_m + b.value_m, a.acceleration_m_s2 + b.acceleration_m_s2};
}

// A zero-moment point from the middle of the foot and its derivatives, by what is common and by what is one rise's own.
struct Row {
  double value = 0;
  Vector3d by_common = Vector3d::Zero();
  VectorXd by_own;
};

// Before the ankle, where the zero-moment point is on average in this posture.
double UsualPlace(const LegPoints& points, const LegBody& body, const TrunkPrior& prior) {
  const double tilt_rad = std::abs(SegmentBetween(points[kKnee], points[kHip]).tilt_rad);
  const double seated = std::clamp(tilt_rad / RadiansFromDegrees(90), 0.0, 1.0);
  return std::lerp(prior.place_standing, prior.place_seated, seated) * body.sole.Length() - body.sole.heel_m;
}

VectorXd Normal(std::mt19937_64& random, Eigen::Index count) {
  std::normal_distribution<double> normal;
  VectorXd values(count);
  for (double& value : values) value = normal(random);
  return values;
}

}  // namespace

TrunkFit::TrunkFit(const LegPath& path, const LegBody& body, const std::vector<Window>& windows,
                   const TrunkPrior& prior) {
  for (const Window& window : windows) {
    if (window.end <= window.begin) continue;
    const std::vector<double> times(path.time_s.begin() + static_cast<std::ptrdiff_t>(window.begin),
                                    path.time_s.begin() + static_cast<std::ptrdiff_t>(window.end));
    const SplineGrid grid = MakeSplineGrid(times, prior.wobble_step_s);
    const auto count = static_cast<Eigen::Index>(grid.count) + 2;
    pieces_.push_back(
        {window, grid, VectorXd::Zero(count), Eigen::LLT<MatrixXd>(MatrixXd::Identity(count, count)), {}, {}});
  }
  if (pieces_.empty()) throw Fail("trunk: there is no time at which the feet alone bear the body");
  constexpr int kRounds = 3;  // the zero-moment point is nearly linear in all that is sought
  for (int round = 0; round < kRounds; ++round) Linearize(path, body, prior);
}

const TrunkFit::Piece* TrunkFit::PieceAt(std::size_t frame) const {
  for (const Piece& piece : pieces_)
    if (frame >= piece.window.begin && frame < piece.window.end) return &piece;
  return nullptr;
}

Vector2d TrunkFit::InTrunkM(std::size_t frame) const {
  const Piece* piece = PieceAt(frame);
  const Vector2d common = common_.head<2>();
  return piece ? Vector2d(common + piece->own.tail<2>()) : common;
}

Displacement TrunkFit::At(const LegPath& path, std::size_t frame) const {
  const LegPoints& points = path.frames[frame];
  const SegmentMotion trunk = SegmentBetween(points[kHip], points[kTrunkTop]);
  const Vector2d in_trunk_m = InTrunkM(frame);
  const Displacement fixed = FixedInTrunk(trunk, in_trunk_m.x(), in_trunk_m.y());
  const Piece* piece = PieceAt(frame);
  return piece ? fixed + Wobble(piece->grid, path.time_s[frame], piece->own) : fixed;
}

void TrunkFit::Accumulate(const LegPath& path, const LegBody& body, const TrunkPrior& prior, Piece& piece,
                          Eigen::Matrix3d& normal, Vector3d& right) const {
  const Eigen::Index count = piece.own.size();
  const double spread_m = prior.spread * body.sole.Length();
  const auto row_at = [&](std::size_t i) {
    const LegPoints& points = path.frames[i];
    const Displacement trunk = At(path, i);
    const LegLoads loads = LoadsFromTrunk(points, body, trunk);
    const Body centre = TrunkBody(points, body, trunk);
    const Vector2d ground = GroundPoint(points, body);
    const auto by = [&](const Displacement& change) {
      const Wrench wrench = WrenchChange(centre, change, ground);
      return (wrench.moment_nm - loads.zmp_m * wrench.force_n.y()) / loads.ground_force_n.y();
    };
    const SegmentMotion motion = SegmentBetween(points[kHip], points[kTrunkTop]);
    Row row{.value = loads.zmp_m - UsualPlace(points, body, prior) - common_[2],
            .by_common = {by(FixedInTrunk(motion, 1, 0)), by(FixedInTrunk(motion, 0, 1)), -1},
            .by_own = VectorXd::Zero(count)};
    const SplineGrid::Place place = piece.grid.At(path.time_s[i]);
    for (std::size_t a = 0; a < 4; ++a)
      row.by_own[static_cast<Eigen::Index>(place.first + a)] = by({{place.value[a], 0}, {place.curve[a], 0}});
    row.by_own.tail<2>() = row.by_common.head<2>();
    return row;
  };
  VectorXd sigma_m = VectorXd::Constant(count, prior.wobble_m * kCoefficientsPerValue);
  sigma_m.tail<2>().setConstant(prior.posture_m);
  MatrixXd own = sigma_m.cwiseAbs2().cwiseInverse().asDiagonal();
  piece.coupling = MatrixXd::Zero(count, 3);
  piece.right = VectorXd::Zero(count);
  const auto add = [&](const Row& row, double sigma) {
    const VectorXd by_own = row.by_own / sigma;
    const Vector3d by_common = row.by_common / sigma;
    const double sought = by_common.dot(common_) + by_own.dot(piece.own) - row.value / sigma;
    own.selfadjointView<Eigen::Lower>().rankUpdate(by_own);
    piece.coupling += by_own * by_common.transpose();
    normal += by_common * by_common.transpose();
    piece.right += sought * by_own;
    right += sought * by_common;
  };
  std::optional<Row> last;
  double last_s = 0;
  const double weight_n = kGravity_m_s2 * (body.trunk.mass_kg + body.thigh.mass_kg + body.shank.mass_kg);
  for (std::size_t i = piece.window.begin; i < piece.window.end; ++i) {
    // Near free fall the point is nowhere, and says nothing.
    if (!path.known[i] || LoadsFromTrunk(path.frames[i], body, At(path, i)).ground_force_n.y() < 0.2 * weight_n) {
      last.reset();
      continue;
    }
    Row row = row_at(i);
    if (last) {
      const double kept = std::exp(-(path.time_s[i] - last_s) / prior.memory_s);
      add({row.value - kept * last->value, row.by_common - kept * last->by_common, row.by_own - kept * last->by_own},
          spread_m * std::sqrt(1 - kept * kept));
    } else {
      add(row, spread_m);
    }
    last = std::move(row);
    last_s = path.time_s[i];
  }
  piece.factor.compute(own.selfadjointView<Eigen::Lower>());
}

void TrunkFit::Linearize(const LegPath& path, const LegBody& body, const TrunkPrior& prior) {
  const Vector3d sigma(prior.along_m, path.has_shoulder ? prior.across_m : prior.across_from_waist_m, prior.habit_m);
  Eigen::Matrix3d normal = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  Vector3d right = Vector3d::Zero();
  for (Piece& piece : pieces_) {
    Accumulate(path, body, prior, piece, normal, right);
    const MatrixXd solved = piece.factor.solve(piece.coupling);
    normal -= piece.coupling.transpose() * solved;
    right -= solved.transpose() * piece.right;
  }
  common_covariance_ = normal.inverse();
  common_ = common_covariance_ * right;
  for (Piece& piece : pieces_) piece.own = piece.factor.solve(piece.right - piece.coupling * common_);
}

TrunkFit TrunkFit::Draw(std::mt19937_64& random) const {
  TrunkFit drawn = *this;
  const Eigen::LLT<Eigen::Matrix3d> factor(common_covariance_);
  const Vector3d change = factor.matrixL() * Normal(random, 3);
  drawn.common_ += change;
  for (Piece& piece : drawn.pieces_) {
    piece.own -= piece.factor.solve(piece.coupling * change);
    piece.own += piece.factor.matrixU().solve(Normal(random, piece.own.size()));
  }
  return drawn;
}

}  // namespace lake::loads
