// A trial from any known file: what lake-gait, lake-compare and lake convert read.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lake/exchange/point_recording.h"
#include "lake/motion/leg_motion.h"

namespace lake {

struct TrialOptions {
  std::map<std::string, std::string> names;  // own name → the file's; "A+B" is the middle of two markers
  std::optional<char> up;                    // x, y or z of a 3-D file; default: the file's own, TRC y, C3D z
  std::string forward;                       // "x", "+x", "-z", …; empty: the plane is fitted to the leg's motion
  double mm_per_unit = 1;                    // of files that do not say their unit
};

struct Trial {
  std::filesystem::path file;  // that was read: of a folder, its trajectory.csv or tracks.csv
  MarkerRecording recording;   // in the sagittal plane, or in px
  std::optional<double> mm_per_px;
  std::optional<bool> faces_right;  // known if `forward` was given
  double out_of_plane_mm = 0;       // 3-D files: RMS of the leg's movement across the plane
  std::vector<std::string> warnings;
};

// "ankle=RANK,knee=RKNE" as a map. Throws UsageError.
std::map<std::string, std::string> ParseNameMap(const std::string& text);

// A lake-track folder, .csv (lake's own or Kinovea's), .trc, .c3d, .trk, .txt (Tracker). Three dimensions are projected
// onto the vertical plane that holds `forward`, or that fits the movement of the segments between ankle, knee and hip
// best. Throws Error: a file of an unknown kind, a name that is not in it (the message lists those that are).
Trial ReadTrial(const std::filesystem::path& path, const TrialOptions& options = {});

// As it stands in the file, before naming and projection.
PointRecording ReadPoints(const std::filesystem::path& path, double mm_per_unit = 1);

// By the extension: .trc, .c3d, .txt (Tracker), .csv (lake's own; "_kinovea.csv" for Kinovea's). Throws Error for
// others.
void WritePoints(const std::filesystem::path& path, const PointRecording& points);

// The files of `lake-track --export`: NAME.trc, NAME.c3d, NAME_tracker.txt, NAME_kinovea.csv, and for mot the knee
// angle. Throws UsageError for an unknown format.
std::vector<std::filesystem::path> ExportTrial(const std::vector<std::string>& formats,
                                               const std::filesystem::path& folder, const std::string& name,
                                               const PointRecording& points, const LegMotion* motion);

}  // namespace lake
