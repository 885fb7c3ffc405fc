// Sit-to-stand cycles of a rigid leg, in closed form: what the renderer shows when no recorded motion is given.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lake/synth/marker_motion.h"

namespace lake::synth {

// Minimum-jerk progress from 0 to 1 over s in 0..1: 10 s³ − 15 s⁴ + 6 s⁵ (Flash & Hogan, J. Neurosci. 5, 1985); 0
// before, 1 after.
double MinimumJerk(double s);

// Segment angles are from the vertical, positive when the upper end leans forward, as in LegSample; knee = shank −
// thigh.
struct StsMotionOptions {
  std::uint64_t seed = 1;
  motion::Facing facing = motion::Facing::kRight;
  int repetitions = 2;          // rises
  bool start_standing = false;  // begins and ends upright instead of on the seat

  double shank_mm = 400, thigh_mm = 410, trunk_mm = 200;  // ankle–knee, knee–hip, hip–waist

  double seated_knee_deg = 92, standing_knee_deg = 5;
  double seated_shank_deg = 6, standing_shank_deg = 3;
  double peak_shank_deg = 18;  // about seat-off
  double seated_trunk_deg = 4, standing_trunk_deg = 2;
  double peak_trunk_deg = 40;  // about seat-off

  double rise_s = 1.9, descent_s = 2.0;       // natural rising takes 1.7–2.3 s
  double min_rest_s = 0.5, max_rest_s = 1.5;  // between movements, drawn for each
  double variation = 1;         // of angles (SD 1.5°) and durations (SD 4 %) between repetitions; 0: none
  double ankle_sway_mm = 0.2;   // amplitude of slow movement of the ankle, per axis
  double body_sway_deg = 0.15;  // amplitude of slow movement of each segment
  double skin_mm = 0;           // how far markers slide over their segments: mostly with flexion, a little with time

  // For an exoskeleton trial that differs from a human trial of the same seed in known ways (use variation as in that
  // trial, and no sway or skin movement where the truth must be exact):
  double pace = 1;       // rises and descents take this many times as long
  double time_warp = 0;  // at the fraction s of a rise the pose is that of s + time_warp sin(pi s)
  std::optional<Eigen::Vector2d>
      exo_knee_mm;  // adds `exo_knee` here relative to the knee: shank frame (x anterior, y ankle to knee)
  std::vector<std::string> extra_markers = {};  // on the skin of the shank: shank1, shank2
};

struct StsPhase {
  enum class Kind { kSeated, kRise, kStanding, kDescent };
  Kind kind = Kind::kSeated;
  double start_s = 0, end_s = 0;
};

// Markers ankle, knee, hip, waist and, if asked for, exo_knee and extra ones. The ankle rests at (0, 0).
class StsMotion : public MarkerMotion {
 public:
  // Throws UsageError for lengths or durations that are not positive, no repetition, a warp that turns time back, an
  // extra marker that it does not know.
  explicit StsMotion(const StsMotionOptions& options);

  const std::vector<std::string>& Names() const override { return names_; }
  motion::Facing FacingInImage() const override { return options_.facing; }
  double DurationS() const override { return phases_.back().end_s; }
  std::vector<Eigen::Vector2d> At(double time_s) const override;

  // Rests and movements in order; a movement's start and end are where its minimum-jerk profile leaves and reaches
  // rest.
  const std::vector<StsPhase>& Phases() const { return phases_; }

 private:
  struct Angles {
    double shank = 0, thigh = 0, trunk = 0;  // deg
  };
  struct Movement {
    Angles seated, standing;
    double peak_shank = 0, peak_trunk = 0;
  };
  struct Sway {
    double amplitude = 0;
    double hz[2] = {}, phase_rad[2] = {};
    double At(double time_s) const;
  };

  void DrawPhases();
  Angles AnglesAt(double time_s) const;
  Angles DuringRise(const Movement& movement, double fraction) const;
  void SlideSkin(double time_s, const Angles& angles, std::vector<Eigen::Vector2d>& markers) const;

  StsMotionOptions options_;
  std::vector<std::string> names_;
  std::vector<StsPhase> phases_;
  std::vector<Movement> movements_;  // one per phase; a rest is a movement that stands at one of its ends
  Sway ankle_sway_[2], angle_sway_[3], skin_drift_[8];
};

}  // namespace lake::synth
