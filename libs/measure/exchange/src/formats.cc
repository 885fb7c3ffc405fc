#include "lake/exchange/formats.h"

#include "lake/core/error.h"
#include "lake/core/run.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/dltdv.h"
#include "lake/exchange/kinovea.h"
#include "lake/exchange/mot.h"
#include "lake/exchange/tracker.h"
#include "lake/exchange/trc.h"
#include "lake/motion/marker_recording.h"
#include "marker_files.h"
#include "text_lines.h"

namespace lake::exchange {
namespace {

namespace fs = std::filesystem;

using PointWriter = void (*)(const fs::path&, const PointRecording&);

constexpr const char* kAngles = "mot";  // of the leg's angles, not of points

struct WritableFormat : PointFormat {
  PointWriter write;
};

// A longer ending stands before the shorter one that it ends in.
const std::vector<WritableFormat>& WritableFormats() {
  static const std::vector<WritableFormat> kFormats = {
      {{"trc", ".trc", false, true, true}, [](const fs::path& path, const PointRecording& p) { WriteTrc(path, p); }},
      {{"c3d", ".c3d", false, true, true}, WriteC3d},
      {{"tracker", ".txt", true, true, false}, WriteTrackerText},
      {{"trk", ".trk", true, false, false}, WriteTrk},
      {{"kinovea", "_kinovea.csv", true, true, false}, WriteKinovea},
      {{"kva", ".kva", true, false, false}, WriteKva},
      {{"", ".csv", true, true, false},
       [](const fs::path& path, const PointRecording& p) { motion::WriteMarkerCsv(path, MarkersFromPoints(p)); }}};
  return kFormats;
}

const WritableFormat& WritableFormatOf(const fs::path& path) {
  const std::string name = Lower(path.filename().string());
  for (const WritableFormat& format : WritableFormats())
    if (name.ends_with(format.ending)) return format;
  throw UsageError("{}: .trc, .c3d, .txt (Tracker), .trk, .csv (lake), _kinovea.csv or .kva can be written",
                   path.string());
}

// Of lake's own table: what was measured, or all that a fit estimates.
PointRecording ReadOwnPoints(const fs::path& path, motion::MarkerValues values) {
  const motion::MarkerRecording table = ReadTable(path, values);
  return PointsFromMarkers(values == motion::MarkerValues::kMeasured ? motion::Measurements(table) : table);
}

PointRecording ReadCsv(const fs::path& path, double mm_per_unit, double rate_hz, motion::MarkerValues values) {
  if (IsKinovea(path)) return ReadKinovea(path, mm_per_unit);
  if (IsDltdv(path)) return ReadDltdv(path, rate_hz);
  return ReadOwnPoints(path, values);
}

const WritableFormat& ExportFormat(const std::string& name) {
  for (const WritableFormat& format : WritableFormats())
    if (!name.empty() && format.name == name) return format;
  throw UsageError("--export {}: not a format; there are {}", name, fmt::join(ExportFormats(), ", "));
}

}  // namespace

const PointFormat& FormatOf(const fs::path& path) {
  return WritableFormatOf(path);
}

fs::path TableOfFolder(const fs::path& folder) {
  for (const char* name : {"trajectory.csv", "tracks.csv"})
    if (const auto table = FindResult(folder, name)) return *table;
  throw Fail("{}: the folder has neither trajectory.csv nor tracks.csv of lake-track, nor one .txt or .csv per marker",
             folder.string());
}

motion::MarkerRecording ReadTable(const fs::path& path, motion::MarkerValues values) {
  motion::MarkerRecording table = motion::ReadMarkerCsv(path, values);
  if (values == motion::MarkerValues::kEstimated && table.unit == motion::LengthUnit::kPx)
    throw Fail("{}: holds measurements in px, and no fit's estimates (--smoothed); those are in a trajectory.csv",
               path.string());
  return table;
}

PointRecording ReadPoints(const fs::path& path, double mm_per_unit, double rate_hz, motion::MarkerValues values) {
  if (const std::vector<fs::path> files = MarkerFilesOf(path); !files.empty())
    return ReadMarkerFiles(files, mm_per_unit, rate_hz);
  if (fs::is_directory(path)) return ReadOwnPoints(TableOfFolder(path), values);
  if (!fs::exists(path)) throw Fail("{}: no such file", path.string());
  const std::string extension = Lower(path.extension().string());
  if (extension == ".trc") return ReadTrc(path);
  if (extension == ".c3d") return ReadC3d(path);
  if (extension == ".trk" || extension == ".trz") return ReadTrk(path);
  if (extension == ".kva") return ReadKva(path);
  if (extension == ".txt") return ReadTrackerText(path, mm_per_unit);
  if (extension == ".csv") return ReadCsv(path, mm_per_unit, rate_hz, values);
  throw Fail(
      "{}: unknown kind of file; .trc, .c3d, .trk, .trz, .kva, .txt (Tracker), .csv (lake, Kinovea, DLTdv) are known",
      path.string());
}

void WritePoints(const fs::path& path, const PointRecording& points, const std::string& unit) {
  const WritableFormat& format = WritableFormatOf(path);
  if (points.space == PointSpace::kSpace && !format.space)
    throw Fail("{}: holds points of a plane only, and these are in space", path.string());
  if (format.name == "trc") return WriteTrc(path, points, unit);
  if (unit != "mm") throw UsageError("{}: is always in mm; only .trc can be in {}", path.string(), unit);
  format.write(path, points);
}

std::vector<std::string> ExportFormats() {
  std::vector<std::string> names = {kAngles};
  for (const WritableFormat& format : WritableFormats())
    if (!format.name.empty()) names.push_back(format.name);
  return names;
}

void CheckExportFormats(const std::vector<std::string>& formats, bool has_scale, bool has_leg) {
  for (const std::string& format : formats) {
    if (format != kAngles && !has_scale && !ExportFormat(format).image)
      throw UsageError("--export {}: holds lengths, not px; give --scale, or a --camera with the sagittal plane",
                       format);
    if (format == kAngles && !has_leg)
      throw UsageError("--export mot: holds the leg's angles; ankle, knee and hip must be among the markers");
    if (format != kAngles) ExportFormat(format);
  }
}

std::string ExportName(const std::string& format, const std::string& name) {
  if (format == kAngles) return name + ".mot";
  // Tracker's text says by its name which program it is of, as a .txt may be anything.
  return name + (format == "tracker" ? "_tracker" : "") + ExportFormat(format).ending;
}

void ExportTrial(const std::string& format, const fs::path& path, const ExportedTrial& trial) {
  CheckExportFormats({format}, trial.points.space != PointSpace::kImage, trial.motion != nullptr);
  if (format == kAngles) return WriteMot(path, MotFromLegMotion(*trial.motion, trial.leg));
  const WritableFormat& writer = ExportFormat(format);
  writer.write(path, writer.plane ? trial.points : trial.image);
}

}  // namespace lake::exchange
