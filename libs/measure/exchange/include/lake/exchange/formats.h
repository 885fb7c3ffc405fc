// The formats of point files by their ending: reading, writing, and the exports of lake-track.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/exchange/point_recording.h"
#include "lake/motion/leg_motion.h"

namespace lake::exchange {

// A format that can be written, with the kinds of points it holds.
struct PointFormat {
  std::string name;    // as `lake-track --export` has it; empty for lake's own table
  std::string ending;  // of the file's name
  bool image = false, plane = false, space = false;
};

// Throws UsageError naming the endings that are known.
const PointFormat& FormatOf(const std::filesystem::path& path);

// As it stands in the file, before naming and projection: a lake-track folder, .trc, .c3d, .trk, .trz, .kva, .txt
// (Tracker), .csv (lake's own, Kinovea's, DLTdv's); endings in any case; or a folder with one .txt or .csv per marker,
// which gives the marker its name. `mm_per_unit` and `rate_hz` are for files that
// do not say, `values` for those of lake's own tables that hold both kinds. Throws Error for others.
PointRecording ReadPoints(const std::filesystem::path& path, double mm_per_unit = 1, double rate_hz = 0,
                          motion::MarkerValues values = motion::MarkerValues::kMeasured);

// One of lake's own tables. Throws Error for estimates of a table in px: tracks.csv holds measurements.
motion::MarkerRecording ReadTable(const std::filesystem::path& path, motion::MarkerValues values);

// The table that lake-track left in its folder: trajectory.csv, or tracks.csv. Throws Error if there is neither.
std::filesystem::path TableOfFolder(const std::filesystem::path& folder);

// By the ending. `unit` is that of TRC: mm, cm or m. Throws Error for points that the format does not hold.
void WritePoints(const std::filesystem::path& path, const PointRecording& points, const std::string& unit = "mm");

// The formats of `lake-track --export`: trc, mot, …
std::vector<std::string> ExportFormats();

// Throws UsageError for a format that is not among them, without a scale for one that holds lengths only, and without a
// leg for one that holds its angles.
void CheckExportFormats(const std::vector<std::string>& formats, bool has_scale, bool has_leg);

// The data of a trial to export.
struct ExportedTrial {
  PointRecording points;                      // in mm, or px without a scale
  PointRecording image;                       // in px, for formats that lie over the video
  const motion::LegMotion* motion = nullptr;  // for mot; none if there is no leg
  motion::Side leg = motion::Side::kRight;    // whose motion it is
};

// One format's file: NAME.trc, NAME.mot (the knee angle), NAME.c3d, NAME_tracker.txt, NAME.trk, NAME_kinovea.csv,
// NAME.kva. Throws UsageError for an unknown format.
std::string ExportName(const std::string& format, const std::string& name);

// Writes one format's file. Throws UsageError as CheckExportFormats, Error where the format cannot hold the trial.
void ExportTrial(const std::string& format, const std::filesystem::path& path, const ExportedTrial& trial);

}  // namespace lake::exchange
