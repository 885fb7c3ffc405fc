#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/cross.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/linkage/linkage.h"

namespace lake::linkage {
namespace {

using Eigen::Vector2d;
constexpr double kAngleRounding_rad = 1e-9;
constexpr double kPointRounding = 1e-12;  // relative to a link

double StrokeForBar(const Links& l, double phi) {
  const double l7 = l.L7(), alpha2 = phi - std::atan2(l.l5, l.l6);
  return std::hypot(l7 - l.l2, 2 * std::sqrt(l7 * l.l2) * std::sin(alpha2 / 2));
}

// An angle moved by whole turns into [lowest, lowest + 2 pi).
double WrapFrom(double angle, double lowest) {
  return angle - 2 * kPi * std::floor((angle - lowest) / (2 * kPi));
}

// Whether b is within half a turn clockwise of a, as the bar's and the shank's angles are counted.
bool IsWithinHalfTurn(const Vector2d& a, const Vector2d& b) {
  return Cross(b, a) >= -kAngleRounding_rad * a.norm() * b.norm();
}

// Where the bar tip is at a point of the assembled branch: its stroke, and the knee angle continued along the branch.
struct TipState {
  double stroke_mm, theta_rad;
};

// nullopt if the tip, with the shank pin at S, is on another branch, or on the knee pivot, where the shank is free.
// Searches come here millions of times: sides are found by cross products, angles worked out on the branch alone.
std::optional<TipState> StateOfTip(const Links& l, const Vector2d& tip, const Vector2d& shank_pin) {
  if (tip.norm() <= kPointRounding * l.l2) return std::nullopt;
  const Vector2d thigh_pin(0, l.l3), mount(l.l5, l.l6), bar = tip - thigh_pin;
  if (!IsWithinHalfTurn(mount, bar) || !IsWithinHalfTurn(tip, shank_pin)) return std::nullopt;
  double beta1 = std::atan2(tip.x(), tip.y());
  // On the branch phi is within half a turn of the mount's angle, which is below a quarter: beyond pi where x < 0.
  if (bar.x() < 0 && l.l2 > l.l3) beta1 = WrapFrom(beta1, 0);
  const double beta2 = WrapFrom(std::atan2(shank_pin.x(), shank_pin.y()) - beta1, -kAngleRounding_rad);
  return TipState{(bar - mount).norm(), kPi - beta1 - beta2};
}

// Where the circles of l2 about P and l1 about S meet, if they do; twice the same point where they touch.
std::optional<std::array<Vector2d, 2>> TipsForShankPin(const Links& l, const Vector2d& shank_pin) {
  const Vector2d thigh_pin(0, l.l3), across = shank_pin - thigh_pin;
  const double distance = across.norm();
  const double closed =
      (l.l1 + l.l2 + distance) * (l.l1 + l.l2 - distance) * (distance + (l.l2 - l.l1)) * (distance - (l.l2 - l.l1));
  if (distance == 0 || closed < 0) return std::nullopt;
  const double along = (l.l2 * l.l2 - l.l1 * l.l1 + distance * distance) / (2 * distance);
  const double aside = std::sqrt(closed) / (2 * distance);
  const Vector2d direction = across / distance, normal(-direction.y(), direction.x());
  return {{thigh_pin + along * direction + aside * normal, thigh_pin + along * direction - aside * normal}};
}

}  // namespace

std::vector<StrokeRange> AssemblyRanges(const Links& links) {
  const double product = 2 * links.l2 * links.l3, squares = links.l2 * links.l2 + links.l3 * links.l3;
  const double shortest = std::abs(links.l4 - links.l1), longest = links.l4 + links.l1;
  const double cosine_at_shortest = (shortest * shortest - squares) / product;
  const double cosine_at_longest = (longest * longest - squares) / product;
  if (cosine_at_longest < -1 || cosine_at_shortest > 1) return {};
  const double first = std::acos(std::min(1.0, cosine_at_longest)),
               last = std::acos(std::max(-1.0, cosine_at_shortest));
  const double alpha1 = std::atan2(links.l5, links.l6);
  std::vector<StrokeRange> ranges;
  const auto add = [&](double from, double to) {
    from = std::max(from, alpha1);
    to = std::min(to, alpha1 + kPi);
    if (from <= to) ranges.push_back({StrokeForBar(links, from), StrokeForBar(links, to)});
  };
  if (last == kPi && links.l2 == links.l3) {  // the tip would meet the knee pivot, where the shank is free
    add(first, kPi - kAngleRounding_rad);
    add(kPi + kAngleRounding_rad, 2 * kPi - first);
  } else if (last == kPi) {
    add(first, 2 * kPi - first);
  } else {
    add(first, last);
    add(2 * kPi - last, 2 * kPi - first);
  }
  return ranges;
}

std::vector<double> TurningStrokes(const Links& links) {
  std::vector<double> strokes;
  const Vector2d thigh_pin(0, links.l3);
  for (const double coupler : {links.l1, -links.l1}) {  // S beyond the tip, or folded back from it
    const double reach = std::abs(links.l2 + coupler);
    const double cosine = (links.l3 * links.l3 + links.l4 * links.l4 - reach * reach) / (2 * links.l3 * links.l4);
    if (std::abs(cosine) > 1 || reach == 0) continue;
    const double sine = std::sqrt((1 - cosine) * (1 + cosine));
    for (const double side : {1.0, -1.0}) {
      const Vector2d shank_pin = links.l4 * Vector2d(side * sine, cosine);
      const Vector2d tip = thigh_pin + links.l2 / (links.l2 + coupler) * (shank_pin - thigh_pin);
      if (const auto state = StateOfTip(links, tip, shank_pin)) strokes.push_back(state->stroke_mm);
    }
  }
  std::sort(strokes.begin(), strokes.end());
  return strokes;
}

std::vector<double> StrokesForAngle(const Links& links, double theta_rad) {
  std::vector<double> strokes;
  const Vector2d shank_pin = links.l4 * Vector2d(std::sin(theta_rad), -std::cos(theta_rad));
  const auto tips = TipsForShankPin(links, shank_pin);
  if (!tips) return strokes;
  for (const Vector2d& tip : *tips) {
    const auto state = StateOfTip(links, tip, shank_pin);
    if (state && std::abs(state->theta_rad - theta_rad) < kPi) strokes.push_back(state->stroke_mm);
  }
  std::sort(strokes.begin(), strokes.end());
  return strokes;
}

UsedRange FindUsedRange(const Links& links, double d_min_mm, std::optional<double> d_max_mm, double least_theta_rad) {
  const Pose at_lower = RequirePose(links, d_min_mm);
  if (d_max_mm && !(*d_max_mm > d_min_mm)) throw Fail("d_max = {} mm must exceed d_min = {} mm", *d_max_mm, d_min_mm);
  const auto ranges = AssemblyRanges(links);
  const auto home =
      std::find_if(ranges.begin(), ranges.end(), [&](const auto& range) { return range.Contains(d_min_mm); });
  UsedRange used{.stroke = {d_min_mm, home == ranges.end() ? d_min_mm : home->upper_mm},
                 .theta_at_lower_rad = at_lower.theta_rad,
                 .theta_at_upper_rad = 0,
                 .end = UsedRange::End::kAssembly};
  const auto end_at = [&](double stroke_mm, UsedRange::End end) {
    if (stroke_mm <= d_min_mm || stroke_mm >= used.stroke.upper_mm) return;
    used.stroke.upper_mm = stroke_mm;
    used.end = end;
  };
  for (const double stroke : TurningStrokes(links)) end_at(stroke, UsedRange::End::kTurning);
  for (const double stroke : StrokesForAngle(links, least_theta_rad)) end_at(stroke, UsedRange::End::kStanding);
  if (d_max_mm) end_at(*d_max_mm, UsedRange::End::kDMax);
  used.theta_at_upper_rad =
      used.end == UsedRange::End::kStanding ? least_theta_rad : RequirePose(links, used.stroke.upper_mm).theta_rad;
  return used;
}

std::optional<double> StrokeForAngle(const Links& links, const UsedRange& range, double theta_rad) {
  for (const double stroke : StrokesForAngle(links, theta_rad))
    if (range.stroke.Contains(stroke)) return std::clamp(stroke, range.stroke.lower_mm, range.stroke.upper_mm);
  return std::nullopt;
}

}  // namespace lake::linkage
