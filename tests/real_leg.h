// The real sit-to-stand of ../shared/data/opencap_sts, recorded with optical markers.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "lake/synth/motion_file.h"
#include "places.h"

namespace lake {

// One leg, "right" or "left", facing right: ankle, knee, hip, and as waist the middle of the pelvis' front and back.
// nullopt where the recordings are absent.
inline std::optional<synth::MotionFile> RealLegFile(const std::string& side) {
  const std::filesystem::path file = SharedData() / "opencap_sts/sts_default_markers.trc";
  if (!std::filesystem::is_regular_file(file)) return std::nullopt;
  const bool right = side == "right";
  synth::MotionFile motion;
  motion.file = file;
  motion.reading.names = {{"ankle", right ? "r_ankle" : "L_ankle"},
                          {"knee", right ? "r_knee" : "L_knee"},
                          {"hip", right ? "R_HJC" : "L_HJC"},
                          {"waist", right ? "r.ASIS+r.PSIS" : "L.ASIS+L.PSIS"}};
  motion.reading.forward = "+x";
  return motion;
}

// The same in the recording's x–y plane, mm.
inline std::optional<synth::MotionTable> RealLeg(const std::string& side) {
  const auto file = RealLegFile(side);
  if (!file) return std::nullopt;
  synth::MotionTable table = synth::ReadMotionFile(*file, 0);
  table.depth_mm.clear();
  return table;
}

}  // namespace lake
