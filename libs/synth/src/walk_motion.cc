#include "lake/synth/walk_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/synth/sts_motion.h"

namespace lake::synth {
namespace {

using Eigen::Vector2d;

struct Foot {
  Vector2d heel, toe, ankle;
};

Foot DrawFoot(double phase, const DrawnStride& o) {
  constexpr double kFoot_mm = 200, kSole_mm = 40, kOff_deg = -55, kStrike_deg = 15, kFlat = 0.14;
  const double whole = std::floor(phase), u = phase - whole, rise = 0.6 * o.stance;
  const auto along = [](double deg) {
    return Vector2d(std::cos(RadiansFromDegrees(deg)), std::sin(RadiansFromDegrees(deg)));
  };
  Vector2d heel(0, kSole_mm);
  double pitch_deg = 0;
  if (u < kFlat) {
    pitch_deg = kStrike_deg * std::pow(1 - u / kFlat, 2);
  } else if (u < o.stance) {
    pitch_deg = kOff_deg * std::pow(std::max(0.0, (u - rise) / (o.stance - rise)), 2);
    heel = Vector2d(kFoot_mm, kSole_mm) - kFoot_mm * along(pitch_deg);
  } else {
    const double v = (u - o.stance) / (1 - o.stance);
    pitch_deg = kOff_deg + (kStrike_deg - kOff_deg) * MinimumJerk(v / 0.9);
    const Vector2d from = Vector2d(kFoot_mm, kSole_mm) - kFoot_mm * along(kOff_deg);
    heel.x() = from.x() + (o.stride_mm - from.x()) * MinimumJerk(0.05 + 0.95 * v);
    heel.y() = kSole_mm + (from.y() - kSole_mm) * std::pow(1 - v, 4) * (1 + 4 * v) + 260 * v * v * (1 - v) +
               2500 * v * v * std::pow(1 - v, 4);
  }
  heel.x() += whole * o.stride_mm;
  const Vector2d forward = along(pitch_deg), up(-forward.y(), forward.x());
  return {heel, heel + kFoot_mm * forward, heel + 45 * forward + 50 * up};
}

// Of two segments of 435 mm, bent forward.
Vector2d KneeBetween(const Vector2d& ankle, const Vector2d& hip) {
  const Vector2d leg = hip - ankle;
  const double bent = std::sqrt(std::max(0.0, std::pow(435, 2) - leg.squaredNorm() / 4));
  return ankle + leg / 2 + bent * Vector2d(leg.y(), -leg.x()).normalized();
}

constexpr double kBeyond_s = 0.1;  // of the motion, for exposures at its ends

class Passes : public MarkerMotion {
 public:
  Passes(std::unique_ptr<MarkerMotion> pass, const WalkOptions& walk)
      : pass_(std::move(pass)), passes_(walk.passes), period_s_(pass_->DurationS() + walk.pause_s) {}

  const std::vector<std::string>& Names() const override { return pass_->Names(); }
  motion::Facing FacingInImage() const override { return pass_->FacingInImage(); }
  double DurationS() const override { return (passes_ - 1) * period_s_ + pass_->DurationS(); }
  std::vector<Vector2d> At(double time_s) const override { return pass_->At(InPass(time_s)); }
  std::vector<double> DepthsAt(double time_s) const override { return pass_->DepthsAt(InPass(time_s)); }

 private:
  double InPass(double time_s) const {
    const double pass = std::clamp(std::floor(time_s / period_s_), 0.0, static_cast<double>(passes_ - 1));
    return time_s - pass * period_s_;
  }

  std::unique_ptr<MarkerMotion> pass_;
  int passes_;
  double period_s_;
};

}  // namespace

std::map<std::string, Vector2d> DrawWalk(double phase, const DrawnStride& stride) {
  const Foot own = DrawFoot(phase, stride), other = DrawFoot(phase - 0.5, stride);
  const Vector2d step(0.5 * stride.stride_mm, 0);
  // The heel strikes a quarter of a stride and some before the hip.
  const Vector2d hip(phase * stride.stride_mm - 0.22 * stride.stride_mm,
                     915 + 15 * std::cos(4 * std::numbers::pi * (phase - 0.25)));
  return {{"ankle", own.ankle},
          {"knee", KneeBetween(own.ankle, hip)},
          {"hip", hip},
          {"waist", hip + Vector2d(0, 200)},
          {"heel", own.heel},
          {"toe", own.toe},
          {"other_ankle", other.ankle + step},
          {"other_knee", KneeBetween(other.ankle + step, hip)},
          {"other_heel", other.heel + step},
          {"other_toe", other.toe + step}};
}

MotionTable RepeatStride(const MotionTable& table, const WalkOptions& walk) {
  constexpr double kLongestBlend_s = 0.15, kShortestBlend_s = 0.04, kRounding_s = 1e-9;
  const double begin_s = table.time_s.front() + table.before_s, end_s = begin_s + walk.stride_s;
  const double blend_s = std::min(kLongestBlend_s, table.time_s.back() - end_s);
  if (blend_s < kShortestBlend_s - kRounding_s)
    throw Fail("a stride of {:g} s cannot be repeated: the motion must go on for {:g} s after it, and lasts {:.3f} s",
               walk.stride_s, kShortestBlend_s, table.time_s.back() - begin_s);
  MotionTable shifted = table;  // from the stride's begin on, without what is before it
  shifted.before_s = shifted.after_s = 0;
  const std::unique_ptr<MarkerMotion> once = MakeTableMotion(shifted);
  const auto at = [&](double u) { return once->InSpace(begin_s + u - table.time_s.front()); };
  const std::size_t markers = table.names.size();
  Eigen::Vector3d travel = Eigen::Vector3d::Zero();
  const auto first = at(blend_s / 2), next = at(walk.stride_s + blend_s / 2);
  for (std::size_t m = 0; m < markers; ++m) travel.x() += (next[m].x() - first[m].x()) / static_cast<double>(markers);
  const double step_s = walk.stride_s / std::ceil(walk.stride_s * static_cast<double>(table.time_s.size() - 1) /
                                                      (table.time_s.back() - table.time_s.front()) -
                                                  kRounding_s);
  const auto per_stride = static_cast<int>(std::lround(walk.stride_s / step_s));
  const auto beyond = static_cast<int>(std::ceil(kBeyond_s / step_s));
  MotionTable walked{.time_s = {}, .names = table.names, .positions = {}, .depth_mm = {}};
  walked.positions.resize(markers);
  walked.depth_mm.resize(markers);
  walked.before_s = walked.after_s = beyond * step_s;
  for (int i = -beyond; i <= walk.strides * per_stride + beyond; ++i) {
    const int stride = static_cast<int>(std::floor(static_cast<double>(i) / per_stride));
    const double u = step_s * (i - stride * per_stride), share = MinimumJerk(u / blend_s);
    const auto here = at(u), before = at(u + (share < 1 ? walk.stride_s : 0));
    walked.time_s.push_back(step_s * i);
    for (std::size_t m = 0; m < markers; ++m) {
      const Eigen::Vector3d place = stride * travel + share * here[m] + (1 - share) * (before[m] - travel);
      walked.positions[m].emplace_back(place.head<2>());
      walked.depth_mm[m].push_back(place.z());
    }
  }
  return walked;
}

MotionTable DrawnWalkTable(const WalkOptions& walk, motion::Facing facing) {
  const DrawnStride& stride = walk.drawn;
  constexpr double kRate_hz = 200;
  // The drawn foot takes and leaves the ground's speed at once, a person's within some 15 ms (SD).
  constexpr std::pair<double, double> kYields[] = {{-0.03, 0.054}, {-0.02, 0.111}, {-0.01, 0.208}, {0, 0.254},
                                                   {0.01, 0.208},  {0.02, 0.111},  {0.03, 0.054}};
  const double forward = facing == motion::Facing::kRight ? 1 : -1, length_s = walk.strides * stride.stride_s;
  MotionTable table;
  table.before_s = table.after_s = kBeyond_s;
  table.names = {"ankle", "knee", "hip", "waist"};
  for (const std::string& name : walk.drawn_markers) {
    if (!DrawWalk(0, stride).contains(name))
      throw UsageError(
          "--extra-markers: a drawn walk has no '{}'; it has heel, toe, other_ankle, other_knee, "
          "other_heel and other_toe",
          name);
    if (std::ranges::count(table.names, name) == 0) table.names.push_back(name);
  }
  table.positions.resize(table.names.size());
  const auto last = static_cast<int>(std::lround((length_s + kBeyond_s) * kRate_hz));
  for (int i = -static_cast<int>(kBeyond_s * kRate_hz); i <= last; ++i) {
    table.time_s.push_back(i / kRate_hz);
    for (auto& places : table.positions) places.emplace_back(0, 0);
    for (const auto& [after_s, share] : kYields) {
      const auto pose = DrawWalk((i / kRate_hz + after_s) / stride.stride_s - 0.3, stride);
      for (std::size_t m = 0; m < table.names.size(); ++m)
        table.positions[m].back() += share * Vector2d(forward, 1).cwiseProduct(pose.at(table.names[m]));
    }
  }
  table.after_s = table.time_s.back() - length_s;
  return table;
}

std::unique_ptr<MarkerMotion> MakeWalk(MotionTable table, const WalkOptions& walk) {
  const std::unique_ptr<MarkerMotion> once = MakeTableMotion(table);
  const int hip = IndexOfMarker(*once, "hip");
  if (hip < 0) throw Fail("a walk needs a marker 'hip'");
  const double length_s = once->DurationS(), from = once->At(0)[hip].x(), to = once->At(length_s)[hip].x();
  for (auto& places : table.positions)
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double since_middle_s = table.time_s[i] - table.time_s.front() - table.before_s - length_s / 2;
      places[i].x() -= (from + to) / 2 + (walk.is_treadmill ? (to - from) / length_s * since_middle_s : 0);
    }
  std::unique_ptr<MarkerMotion> pass = MakeTableMotion(std::move(table));
  if (walk.passes == 1) return pass;
  return std::make_unique<Passes>(std::move(pass), walk);
}

std::vector<double> PassEnds(const MarkerMotion& motion, const WalkOptions& walk) {
  const double pass_s = (motion.DurationS() - (walk.passes - 1) * walk.pause_s) / walk.passes;
  std::vector<double> ends;
  for (int pass = 1; pass < walk.passes; ++pass) {
    ends.push_back(pass * (pass_s + walk.pause_s) - walk.pause_s);
    ends.push_back(pass * (pass_s + walk.pause_s));
  }
  return ends;
}

void AddExoKnee(MotionTable& table, const Vector2d& from_knee_mm) {
  const auto of = [&](const char* name) {
    const auto found = std::ranges::find(table.names, name);
    if (found == table.names.end() || std::ranges::count(table.names, "exo_knee") > 0)
      throw UsageError("--exo: the motion has no marker '{}', or has exo_knee itself", name);
    return static_cast<std::size_t>(found - table.names.begin());
  };
  const std::size_t ankle = of("ankle"), knee = of("knee");
  const double forward = FacingOf(table) == motion::Facing::kRight ? 1 : -1;
  std::vector<Vector2d> path;
  for (std::size_t i = 0; i < table.time_s.size(); ++i) {
    const Vector2d up = (table.positions[knee][i] - table.positions[ankle][i]).normalized();
    path.emplace_back(table.positions[knee][i] + from_knee_mm.x() * forward * Vector2d(up.y(), -up.x()) +
                      from_knee_mm.y() * up);
  }
  table.names.emplace_back("exo_knee");
  table.positions.push_back(std::move(path));
  if (!table.depth_mm.empty()) table.depth_mm.push_back(table.depth_mm[knee]);
}

}  // namespace lake::synth
