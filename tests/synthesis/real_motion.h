// The recorded sit-to-stand that facts about the re-optimisation were worked out on.
#pragma once

#include <filesystem>
#include <optional>

#include "lake/exchange/trial.h"
#include "lake/gait/butterworth.h"
#include "lake/redesign/human_motion.h"
#include "places.h"

namespace lake {

// Right leg of opencap_sts in its x-y plane, 0.26-0.93 s, Butterworth 6 Hz; nullopt where the recordings are absent.
inline std::optional<redesign::HumanMotion> RealSitToStand() {
  const std::filesystem::path file = SharedData() / "opencap_sts/sts_default_markers.trc";
  if (!std::filesystem::is_regular_file(file)) return std::nullopt;
  exchange::TrialOptions reading;
  reading.names = {{"ankle", "r_ankle"}, {"knee", "r_knee"}, {"hip", "R_HJC"}};
  reading.forward = "+x";
  const motion::MarkerRecording recording = exchange::ReadTrial(file, reading).recording;
  constexpr double kFrom_s = 0.26, kTo_s = 0.93, kCutoff_hz = 6;
  const auto path = [&](const char* name) {
    std::vector<double> x, y;
    for (const motion::MarkerSample& sample : recording.Find(name)->samples)
      x.push_back(sample.position.x()), y.push_back(sample.position.y());
    x = gait::ZeroPhaseButterworthAtTimes(x, recording.time_s, kCutoff_hz);
    y = gait::ZeroPhaseButterworthAtTimes(y, recording.time_s, kCutoff_hz);
    std::vector<Eigen::Vector2d> points;
    for (int percent = 0; percent < compare::kPercentSamples; ++percent) {
      const double frame = 100 * std::lerp(kFrom_s, kTo_s, percent / 100.0);  // 100 Hz from 0 s
      const auto before = static_cast<std::size_t>(frame);
      const double share = frame - static_cast<double>(before);
      points.emplace_back(std::lerp(x[before], x[before + 1], share), std::lerp(y[before], y[before + 1], share));
    }
    return points;
  };
  compare::StsCurve curve;
  curve.ankle = path("ankle");
  curve.knee = path("knee");
  curve.hip = path("hip");
  return redesign::MakeHumanMotion(curve);
}

}  // namespace lake
