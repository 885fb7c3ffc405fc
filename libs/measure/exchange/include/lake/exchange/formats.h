// The formats of point files by their ending: reading, writing, and the exports of lake-track.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "lake/exchange/point_recording.h"
#include "lake/motion/leg_motion.h"

namespace lake::exchange {

constexpr double kInPixels = 0;  // for mm per unit

// What a file does not say itself.
struct ReadOptions {
  double mm_per_unit = 1;                                         // of files that do not say their unit, or kInPixels
  double rate_hz = 0;                                             // of files without times
  motion::MarkerValues values = motion::MarkerValues::kMeasured;  // of lake's own tables that hold both kinds
  std::string view = {};  // the camera, of files with the points of several; empty: all
};

// What is true of a format, added up.
enum FormatTraits : unsigned {
  kNoUnit = 1,       // does not state the unit of its lengths
  kNoTimes = 2,      // nor the times of its frames
  kInSpace = 4,      // is read as points in space
  kEstimates = 8,    // lake's own: has a fit's estimates beside the measurements
  kHoldsImage = 16,  // kinds of points that are written
  kHoldsPlane = 32,
  kHoldsSpace = 64
};

// A format of point files: a row of the table in formats.cc.
struct PointFormat {
  const char* name;                    // of the program or the format, for messages
  std::array<const char*, 2> endings;  // of files' names, in small letters
  const char* mark;                    // what the first line of a file holds, in small letters
  PointRecording (*read)(const std::filesystem::path&, const ReadOptions&);
  unsigned traits = 0;
  void (*write)(const std::filesystem::path&, const PointRecording&) = {};
  const char* written_ending = "";
  const char* export_name = "";  // as `lake-track --export` has it

  bool Is(FormatTraits trait) const { return traits & trait; }
};

// The format that a file is read in. Throws Error for a file that is of none: which formats there are, of what program
// the file seems to be, and how it can be converted.
const PointFormat& FormatOfFile(const std::filesystem::path& path);

// The format that a file is written in, by its ending. Throws UsageError naming the endings that are known.
const PointFormat& FormatOf(const std::filesystem::path& path);

// The endings of files that can be read, for help texts: ".trc, .c3d, …".
std::string ReadableEndings();

// As it stands in the file, before naming and projection: a lake-track folder, a file of any format; or a folder with
// one .txt or .csv per marker, which gives the marker its name. Throws Error for others.
PointRecording ReadPoints(const std::filesystem::path& path, const ReadOptions& options = {});

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
