// The real sit-to-stand of ../shared/data/opencap_sts, recorded with optical markers.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "lake/exchange/trial.h"
#include "lake/synth/marker_motion.h"

namespace lake {

// One leg, "right" or "left", in the recording's x–y plane, mm: ankle, knee, hip, and as waist the middle of the
// pelvis' front and back. nullopt where the recordings are absent.
inline std::optional<synth::MotionTable> RealLeg(const std::string& side) {
  const std::filesystem::path file = std::filesystem::path(LAKE_SHARED_DATA) / "opencap_sts/sts_default_markers.trc";
  if (!std::filesystem::is_regular_file(file)) return std::nullopt;
  const bool right = side == "right";
  exchange::TrialOptions reading;
  reading.names = {{"ankle", right ? "r_ankle" : "L_ankle"},
                   {"knee", right ? "r_knee" : "L_knee"},
                   {"hip", right ? "R_HJC" : "L_HJC"},
                   {"waist", right ? "r.ASIS+r.PSIS" : "L.ASIS+L.PSIS"}};
  reading.up = 'y', reading.forward = "+x";
  const motion::MarkerRecording recording = exchange::ReadTrial(file, reading).recording;
  synth::MotionTable table;
  table.time_s = recording.time_s;
  for (const char* name : {"ankle", "knee", "hip", "waist"}) {
    table.names.push_back(name);
    std::vector<Eigen::Vector2d>& path = table.positions.emplace_back();
    for (const motion::MarkerSample& sample : recording.Find(name)->samples) path.push_back(sample.position);
  }
  return table;
}

}  // namespace lake
