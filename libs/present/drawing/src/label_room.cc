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
  constexpr int kWays = 16;  // 22.5° apart, at which a label's boxes still overlap: no room between them is missed
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
  for (const double tilt : {0.0, 1.0, -1.0})              // straight away from the line, or 45° to it
    for (const double way : {0.5, 0.35, 0.65, 0.2, 0.8})  // its middle first, never its ends, where joints are
      for (const int to_side : {1, -1})
        spots.push_back({from + way * (to - from), (to_side * out + tilt * along).normalized()});
  return spots;
}

void LabelRoom::Avoid(const PlanePath& path, double half_width_mm, double weight) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) lines_.push_back({path[i], path[i + 1], half_width_mm, weight});
}

LabelRoom::Box LabelRoom::BoxAt(const LabelWish& wish, double gap_mm, const LabelPlace& place) const {
  // Of 13 points in DejaVu Sans on their ground, as gnuplot draws them: "M" is 17 px wide, 13 letters are 135, 14 are
  // 146; they are 22 px high at most.
  constexpr double kLetter_px = 10.2, kAround_px = 8, kHeight_px = 24;
  const Array2d half = 0.5 * scale_ * Array2d(kLetter_px * static_cast<double>(wish.letters) + kAround_px, kHeight_px);
  const LabelSpot& spot = wish.spots[place.spot];
  const double reach = (spot.outward.array().abs() * half).sum() + gap_mm * (1 + place.steps);
  const Array2d centre = (spot.at + reach * spot.outward).array();
  return {centre - half, centre + half};
}

// 1: a line. Worse is a label over another one, as both are lost, and worst one that is cut off, even for two others.
double LabelRoom::Covered(const Box& label) const {
  constexpr double kLabel = 3, kOutside = 10;
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

LabelPlace LabelRoom::BestPlace(const LabelWish& wish, double gap_mm, const std::optional<Box>& before) const {
  // All steps and the longest way from the place before count less than a line: a label rather goes far than covers
  // one. What may be covered, such as the leg's edges, is covered where the way round it is a few steps.
  constexpr int kSteps = 16;
  constexpr double kStep = 0.02, kAcrossView = 0.6;
  const double view_mm = std::hypot(view_.right - view_.left, view_.top - view_.bottom);
  double least = std::numeric_limits<double>::infinity();
  LabelPlace best;
  for (int step = 0; step < kSteps; ++step)
    for (std::size_t spot = 0; spot < wish.spots.size(); ++spot) {
      const LabelPlace place{spot, step};
      const Box box = BoxAt(wish, gap_mm, place);
      const double moved_mm = before ? (box.low - before->low).matrix().norm() : 0;
      const double cost = Covered(box) + kStep * step + kAcrossView * moved_mm / view_mm;
      if (cost >= least) continue;
      least = cost;
      best = place;
    }
  return best;
}

std::vector<Vector2d> LabelRoom::Place(const std::vector<LabelWish>& wishes, double gap_mm, LabelPlaces& places) {
  constexpr double kFree = 1;  // below a line
  std::vector<std::optional<Box>> before(wishes.size()), boxes(wishes.size());
  for (std::size_t i = 0; i < wishes.size(); ++i) {
    const auto place = places.find(wishes[i].name);
    if (place == places.end()) continue;
    before[i] = BoxAt(wishes[i], gap_mm, place->second);
    if (Covered(*before[i]) >= kFree) continue;
    boxes[i] = before[i];
    taken_.push_back(*boxes[i]);
  }
  std::vector<Vector2d> centres;
  centres.reserve(wishes.size());
  for (std::size_t i = 0; i < wishes.size(); ++i) {
    if (!boxes[i]) {
      const LabelPlace place = BestPlace(wishes[i], gap_mm, before[i]);
      places[wishes[i].name] = place;
      boxes[i] = BoxAt(wishes[i], gap_mm, place);
      taken_.push_back(*boxes[i]);
    }
    centres.emplace_back(0.5 * (boxes[i]->low + boxes[i]->high));
  }
  return centres;
}

}  // namespace lake::drawing
