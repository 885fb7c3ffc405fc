#include "lake/synth/sts_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "random.h"

namespace lake::synth {
namespace {

using Eigen::Vector2d;

// Where in a rise (0..1) each segment moves. The trunk swings forward first, the shank follows, the thigh lifts off the
// seat; the two strokes of trunk and shank overlap a little, which keeps the turn at the peak lively.
struct Stroke {
  double from, to;
  double At(double s) const { return MinimumJerk((s - from) / (to - from)); }
};
constexpr Stroke kTrunkForward{0, 0.5}, kTrunkBack{0.4, 1}, kShankForward{0.18, 0.55}, kShankBack{0.47, 1},
    kThighUp{0.26, 1};

Vector2d Along(double angle_deg) {
  const double angle = RadiansFromDegrees(angle_deg);
  return {std::sin(angle), std::cos(angle)};
}

// A technical marker in the shank's frame, y up the leg; the skin slides least at its lower end.
struct ExtraMarker {
  const char* name;
  Vector2d from_knee_mm;
  double skin_share;
};
const ExtraMarker kExtraMarkers[] = {{"shank1", {35, -130}, 0.25}, {"shank2", {30, -270}, 0.15}};

const ExtraMarker& ExtraMarkerOf(const std::string& name) {
  const auto found = std::ranges::find(kExtraMarkers, name, &ExtraMarker::name);
  if (found == std::end(kExtraMarkers))
    throw UsageError("--extra-markers {}: a drawn sit-to-stand has shank1 and shank2", name);
  return *found;
}

void CheckOptions(const StsMotionOptions& o) {
  if (o.repetitions < 1 || o.repetitions > 10000)
    throw UsageError("{} repetitions: 1 to 10000 are possible", o.repetitions);
  if (!(o.shank_mm > 0 && o.thigh_mm > 0 && o.trunk_mm > 0)) throw UsageError("segment lengths must be positive");
  if (!(o.skin_mm >= 0 && o.skin_mm <= 100)) throw UsageError("skin movement {} mm: 0 to 100 is possible", o.skin_mm);
  if (!(o.rise_s > 0 && o.descent_s > 0 && o.pace > 0)) throw UsageError("durations and pace must be positive");
  if (!(o.min_rest_s > 0 && o.max_rest_s >= o.min_rest_s))
    throw UsageError("rests must be positive, the longest not below the shortest");
  if (!(std::abs(o.time_warp) < 1 / std::numbers::pi))
    throw UsageError("time warp {}: time would turn back; it must lie within ±{:.3f}", o.time_warp,
                     1 / std::numbers::pi);
}

}  // namespace

double MinimumJerk(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10 + s * (-15 + s * 6));
}

double StsMotion::Sway::At(double time_s) const {
  double sum = 0;
  for (int i = 0; i < 2; ++i) sum += 0.5 * std::sin(2 * std::numbers::pi * hz[i] * time_s + phase_rad[i]);
  return amplitude * sum;
}

StsMotion::StsMotion(const StsMotionOptions& options) : options_(options), names_{"ankle", "knee", "hip", "waist"} {
  CheckOptions(options_);
  if (options_.exo_knee_mm) names_.push_back("exo_knee");
  for (const std::string& name : options_.extra_markers) names_.emplace_back(ExtraMarkerOf(name).name);
  DrawPhases();
  Random random(options_.seed, "sway");
  const auto draw = [&](Sway& sway, double amplitude) {
    sway.amplitude = amplitude;
    for (int i = 0; i < 2; ++i) {
      sway.hz[i] = random.Uniform(0.15, 0.5);
      sway.phase_rad[i] = random.Uniform(0, 2 * std::numbers::pi);
    }
  };
  for (Sway& sway : ankle_sway_) draw(sway, options_.ankle_sway_mm);
  for (Sway& sway : angle_sway_) draw(sway, options_.body_sway_deg);
  for (Sway& sway : skin_drift_) draw(sway, 0.3 * options_.skin_mm);
}

void StsMotion::DrawPhases() {
  using Kind = StsPhase::Kind;
  const StsMotionOptions& o = options_;
  Random shape(o.seed, "movement"), rest(o.seed, "rest");
  const auto vary = [&](double mean, double sd) {
    return mean + o.variation * sd * std::clamp(shape.Normal(), -2.0, 2.0);
  };
  const auto posture = [&](double knee, double shank, double trunk, double sd) {
    const double s = vary(shank, 0.5 * sd);
    return Angles{s, s - vary(knee, sd), vary(trunk, 0.5 * sd)};
  };
  Movement movement{.seated = posture(o.seated_knee_deg, o.seated_shank_deg, o.seated_trunk_deg, 1.5),
                    .standing = posture(o.standing_knee_deg, o.standing_shank_deg, o.standing_trunk_deg, 0.7)};
  double time = 0;
  const auto add = [&](Kind kind, double duration) {
    phases_.push_back({kind, time, time + duration});
    movements_.push_back(movement);
    time += duration;
  };
  const auto rise = [&] {
    movement.standing = posture(o.standing_knee_deg, o.standing_shank_deg, o.standing_trunk_deg, 0.7);
    movement.peak_shank = vary(o.peak_shank_deg, 1.5);
    movement.peak_trunk = vary(o.peak_trunk_deg, 2);
    add(Kind::kRise, o.pace * vary(o.rise_s, 0.04 * o.rise_s));
    add(Kind::kStanding, rest.Uniform(o.min_rest_s, o.max_rest_s));
  };
  const auto descend = [&] {
    movement.seated = posture(o.seated_knee_deg, o.seated_shank_deg, o.seated_trunk_deg, 1.5);
    movement.peak_shank = vary(o.peak_shank_deg, 1.5);
    movement.peak_trunk = vary(o.peak_trunk_deg, 2);
    add(Kind::kDescent, o.pace * vary(o.descent_s, 0.04 * o.descent_s));
    add(Kind::kSeated, rest.Uniform(o.min_rest_s, o.max_rest_s));
  };
  add(o.start_standing ? Kind::kStanding : Kind::kSeated, rest.Uniform(o.min_rest_s, o.max_rest_s));
  for (int i = 0; i < o.repetitions; ++i) {
    if (o.start_standing) {
      descend();
      rise();
    } else {
      rise();
      descend();
    }
  }
}

StsMotion::Angles StsMotion::DuringRise(const Movement& m, double s) const {
  const auto stroke = [s](double from, double peak, double to, const Stroke& forward, const Stroke& back) {
    return from + (peak - from) * forward.At(s) + (to - peak) * back.At(s);
  };
  return {stroke(m.seated.shank, m.peak_shank, m.standing.shank, kShankForward, kShankBack),
          m.seated.thigh + (m.standing.thigh - m.seated.thigh) * kThighUp.At(s),
          stroke(m.seated.trunk, m.peak_trunk, m.standing.trunk, kTrunkForward, kTrunkBack)};
}

StsMotion::Angles StsMotion::AnglesAt(double time_s) const {
  const double time = std::clamp(time_s, 0.0, DurationS());
  const auto after = std::upper_bound(phases_.begin(), phases_.end() - 1, time,
                                      [](double t, const StsPhase& phase) { return t < phase.end_s; });
  const StsPhase& phase = *after;
  const Movement& movement = movements_[static_cast<std::size_t>(after - phases_.begin())];
  const double s = (time - phase.start_s) / (phase.end_s - phase.start_s);
  switch (phase.kind) {
    case StsPhase::Kind::kSeated:
      return movement.seated;
    case StsPhase::Kind::kStanding:
      return movement.standing;
    case StsPhase::Kind::kRise:
      return DuringRise(movement, s + options_.time_warp * std::sin(std::numbers::pi * s));
    case StsPhase::Kind::kDescent:
      return DuringRise(movement, 1 - s);
  }
  return {};
}

std::vector<Vector2d> StsMotion::At(double time_s) const {
  Angles angles = AnglesAt(time_s);
  angles.shank += angle_sway_[0].At(time_s);
  angles.thigh += angle_sway_[1].At(time_s);
  angles.trunk += angle_sway_[2].At(time_s);
  const Vector2d ankle(ankle_sway_[0].At(time_s), ankle_sway_[1].At(time_s));
  const Vector2d shank = Along(angles.shank), shank_anterior(shank.y(), -shank.x());
  const Vector2d knee = ankle + options_.shank_mm * shank;
  const Vector2d hip = knee + options_.thigh_mm * Along(angles.thigh);
  std::vector<Vector2d> markers = {ankle, knee, hip, hip + options_.trunk_mm * Along(angles.trunk)};
  if (options_.exo_knee_mm)
    markers.push_back(knee + options_.exo_knee_mm->x() * shank_anterior + options_.exo_knee_mm->y() * shank);
  const double flexion = std::sin(0.5 * RadiansFromDegrees(angles.shank - angles.thigh));
  for (const std::string& name : options_.extra_markers) {
    const ExtraMarker& marker = ExtraMarkerOf(name);
    const double slid_mm = marker.skin_share * options_.skin_mm * flexion * flexion;
    markers.push_back(knee + marker.from_knee_mm.x() * shank_anterior + (marker.from_knee_mm.y() + slid_mm) * shank);
  }
  if (options_.skin_mm != 0) SlideSkin(time_s, angles, markers);
  if (options_.facing == motion::Facing::kLeft)
    for (Vector2d& marker : markers) marker.x() = -marker.x();
  return markers;
}

void StsMotion::SlideSkin(double time_s, const Angles& angles, std::vector<Vector2d>& markers) const {
  // Skin slides most over the hip, hardly at the ankle.
  constexpr double kShare[4] = {0.1, 0.6, 1.0, 0.5};
  const double flexion = std::sin(0.5 * RadiansFromDegrees(angles.shank - angles.thigh));
  const Vector2d segments[4] = {Along(angles.shank), Along(angles.shank), Along(angles.thigh), Along(angles.trunk)};
  for (int i = 0; i < 4; ++i) {
    const Vector2d across(segments[i].y(), -segments[i].x());
    markers[i] += kShare[i] * ((options_.skin_mm * flexion * flexion + skin_drift_[2 * i].At(time_s)) * segments[i] +
                               skin_drift_[2 * i + 1].At(time_s) * across);
  }
}

}  // namespace lake::synth
