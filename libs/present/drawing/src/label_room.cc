#include "label_room.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace lake::drawing {
namespace {

using Eigen::Array2d, Eigen::Vector2d;

// Whether a part of the line lies between the bounds on both axes (Liang & Barsky 1984).
bool Crosses(const Vector2d& from, const Vector2d& to, const Array2d& low, const Array2d& high) {
  double begin = 0, end = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double along = to[axis] - from[axis];
    if (along == 0) {
      if (from[axis] < low[axis] || from[axis] > high[axis]) return false;
      continue;
    }
    const double a = (low[axis] - from[axis]) / along, b = (high[axis] - from[axis]) / along;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  return begin <= end;
}

}  // namespace

std::vector<LabelSpot> RoundPoint(const Vector2d& at, const Vector2d& first) {
  constexpr int kWays = 16;
  const double heading = std::atan2(first.y(), first.x());
  std::vector<LabelSpot> spots;
  spots.reserve(kWays);
  for (int i = 0; i < kWays; ++i) {  // to both sides in turn, away from the first
    const int steps = (i + 1) / 2;
    const double turned = heading + (i % 2 ? steps : -steps) * 2 * std::numbers::pi / kWays;
    spots.push_back({at, {std::cos(turned), std::sin(turned)}});
  }
  return spots;
}

std::vector<LabelSpot> BesideLine(const Vector2d& from, const Vector2d& to, int side) {
  const Vector2d along = (to - from).normalized(), out = side * Vector2d(along.y(), -along.x());
  std::vector<LabelSpot> spots;
  for (const double tilt : {0.0, 1.0, -1.0})
    for (const double way : {0.5, 0.35, 0.65, 0.2, 0.8})
      for (const int to_side : {1, -1})
        spots.push_back({from + way * (to - from), (to_side * out + tilt * along).normalized()});
  return spots;
}

void LabelRoom::Avoid(const PlanePath& path, double half_width_mm, double weight) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) lines_.push_back({path[i], path[i + 1], half_width_mm, weight});
}

double LabelRoom::Covered(const Box& label) const {
  constexpr double kOutside = 10, kLabel = 3;  // of a line covered
  const bool is_within = label.low.x() >= view_.left && label.high.x() <= view_.right &&
                         label.low.y() >= view_.bottom && label.high.y() <= view_.top;
  double covered = is_within ? 0 : kOutside, lines = 0;
  for (const Box& other : taken_)
    if ((label.low < other.high).all() && (other.low < label.high).all()) covered += kLabel;
  for (const Line& line : lines_)
    if (Crosses(line.from, line.to, label.low - line.half_width_mm, label.high + line.half_width_mm))
      lines = std::max(lines, line.weight);
  return covered + lines;
}

Vector2d LabelRoom::Place(const std::vector<LabelSpot>& spots, double gap_mm, std::size_t letters) {
  constexpr double kLetter_px = 10.2, kAround_px = 8, kHeight_px = 24;  // of 13 points in DejaVu Sans, on their ground
  constexpr int kSteps = 16;
  constexpr double kStep = 0.02;  // what a step further away counts, of a line covered
  const Array2d half = 0.5 * scale_ * Array2d(kLetter_px * static_cast<double>(letters) + kAround_px, kHeight_px);
  double least = std::numeric_limits<double>::infinity();
  Box best{Array2d::Zero(), Array2d::Zero()};
  for (int step = 0; step < kSteps; ++step)
    for (const LabelSpot& spot : spots) {
      const double reach = (spot.outward.array().abs() * half).sum() + gap_mm * (1 + step);
      const Array2d centre = (spot.at + reach * spot.outward).array();
      const Box box{centre - half, centre + half};
      const double cost = Covered(box) + kStep * step;
      if (cost >= least) continue;
      least = cost;
      best = box;
    }
  taken_.push_back(best);
  return (0.5 * (best.low + best.high)).matrix();
}

}  // namespace lake::drawing
