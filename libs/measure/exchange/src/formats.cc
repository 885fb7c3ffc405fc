#include "lake/exchange/formats.h"

#include <algorithm>
#include <fstream>

#include "lake/core/error.h"
#include "lake/core/run.h"
#include "lake/core/utf8.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/mot.h"
#include "lake/motion/marker_recording.h"
#include "readers.h"

namespace lake::exchange {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAngles = "mot";  // of the leg's angles, not of points

// Of lake's own table: what was measured, or all that a fit estimates.
PointRecording ReadOwnPoints(const fs::path& path, const ReadOptions& options) {
  const motion::MarkerRecording table = ReadTable(path, options.values);
  return PointsFromMarkers(options.values == motion::MarkerValues::kMeasured ? motion::Measurements(table) : table);
}

void WriteOwnPoints(const fs::path& path, const PointRecording& points) {
  motion::WriteMarkerCsv(path, MarkersFromPoints(points));
}

}  // namespace

// Each in its own source.
PointRecording ReadTrc(const fs::path& path, const ReadOptions& options);
PointRecording ReadTrackerText(const fs::path& path, const ReadOptions& options);
PointRecording ReadTrk(const fs::path& path, const ReadOptions& options);
PointRecording ReadKinovea(const fs::path& path, const ReadOptions& options);
PointRecording ReadKva(const fs::path& path, const ReadOptions& options);
PointRecording ReadKinoveaText(const fs::path& path, const ReadOptions& options);
PointRecording ReadDltdv(const fs::path& path, const ReadOptions& options);
PointRecording ReadDltdvSparse(const fs::path& path, const ReadOptions& options);
PointRecording ReadDeepLabCut(const fs::path& path, const ReadOptions& options);
PointRecording ReadMotive(const fs::path& path, const ReadOptions& options);
PointRecording ReadSleap(const fs::path& path, const ReadOptions& options);
void WriteTrc(const fs::path& path, const PointRecording& points, const std::string& unit);
void WriteTrackerText(const fs::path& path, const PointRecording& points);
void WriteTrk(const fs::path& path, const PointRecording& points);
void WriteKinovea(const fs::path& path, const PointRecording& points);
void WriteKva(const fs::path& path, const PointRecording& points);

namespace {

void WriteTrcInMm(const fs::path& path, const PointRecording& points) {
  WriteTrc(path, points, "mm");
}

constexpr unsigned kSolid = kHoldsPlane | kHoldsSpace, kFlat = kHoldsImage | kHoldsPlane;

// In the order in which they are tried: a longer ending before the shorter one that it ends in.
const PointFormat kFormats[] = {
    {"TRC", {".trc"}, "", ReadTrc, kInSpace | kSolid, WriteTrcInMm, ".trc", "trc"},
    {"C3D", {".c3d"}, "", ReadC3d, kInSpace | kSolid, WriteC3d, ".c3d", "c3d"},
    {"Kinovea's text", {".txt"}, "#kinovea", ReadKinoveaText, kNoUnit},
    {"Tracker", {".txt"}, "", ReadTrackerText, kNoUnit | kFlat, WriteTrackerText, ".txt", "tracker"},
    {"Tracker's project", {".trk", ".trz"}, "", ReadTrk, kHoldsImage, WriteTrk, ".trk", "trk"},
    {"Kinovea", {".csv"}, "/0/x", ReadKinovea, kNoUnit | kFlat, WriteKinovea, "_kinovea.csv", "kinovea"},
    {"Kinovea's annotations", {".kva"}, "", ReadKva, kHoldsImage, WriteKva, ".kva", "kva"},
    {"DLTdv", {".csv"}, "pt1_cam", ReadDltdv, kNoTimes},
    {"DLTdv's sparse table", {"xypts.tsv"}, "", ReadDltdvSparse, kNoTimes},
    {"DeepLabCut", {".csv"}, "scorer", ReadDeepLabCut, kNoTimes},
    {"OptiTrack Motive", {".csv"}, "format version", ReadMotive, kInSpace},
    {"SLEAP", {".csv"}, "instance.score", ReadSleap, kNoTimes},
    {"lake", {".csv"}, "time_s", ReadOwnPoints, kEstimates | kFlat, WriteOwnPoints, ".csv"}};

// What a format must have for points of each PointSpace, and what is said where it has not.
constexpr std::pair<FormatTraits, const char*> kOfSpaces[] = {
    {kHoldsImage, "is in mm, and these positions in px: give --scale, or a --camera with the sagittal plane"},
    {kHoldsPlane, "holds px of a video, not mm"},
    {kHoldsSpace, "holds points of a plane only, and these are in space"}};

// Files of other programs that are not read, and the way out.
struct ForeignFile {
  const char *ending, *what, *way;
};
constexpr ForeignFile kForeignFiles[] = {
    {".h5", "a table of DeepLabCut or SLEAP in HDF5", "export it there as CSV"},
    {".slp", "a project of SLEAP", "export it there as analysis CSV"},
    {".tak", "a take of OptiTrack Motive", "export it there as CSV, TRC or C3D"},
    {".qtm", "a measurement of Qualisys QTM", "export it there as C3D"},
    {".trb", "a binary recording of Cortex", "export it there as TRC or C3D"},
    {".cap", "a capture of Cortex", "export it there as TRC or C3D"},
    {".x2d", "the camera data of Vicon", "export the trial there as C3D"},
    {".mat", "a file of MATLAB", "write its points as TRC, or as a table with the columns frame,time_s,NAME_x_mm,…"},
    {".bvh", "a skeleton's joint angles", "export the markers as C3D or TRC"},
    {".fbx", "an animation", "export the markers as C3D or TRC"}};

bool HasEnding(const PointFormat& format, const std::string& name) {
  return std::ranges::any_of(format.endings, [&](const char* ending) { return ending && name.ends_with(ending); });
}

std::string FirstLineOf(const fs::path& path) {
  constexpr std::size_t kBytes = 4096;
  std::string head(kBytes, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), kBytes);
  head.resize(static_cast<std::size_t>(file.gcount()));
  head = TextFromBytes(std::move(head));
  return head.substr(0, head.find_first_of("\r\n"));
}

[[noreturn]] void ThrowUnknown(const fs::path& path, const std::string& name, const std::string& head) {
  for (const ForeignFile& file : kForeignFiles)
    if (name.ends_with(file.ending))
      throw Fail("{}: is {}, which is not read here: {}", path.string(), file.what, file.way);
  std::vector<std::string> same;
  for (const PointFormat& format : kFormats)
    if (HasEnding(format, name)) same.push_back(format.name);
  if (same.empty())
    throw Fail("{}: unknown kind of file; {} are known (of a video, lake track makes a trial)", path.string(),
               ReadableEndings());
  constexpr std::size_t kShown = 60;
  throw Fail(
      "{}: its first line is '{}', as no program known here begins such a file ({}); export TRC or C3D instead, or "
      "write a table with the columns frame,time_s,NAME_x_mm,NAME_y_mm,…",
      path.string(), ReadableUtf8(head.substr(0, kShown)), fmt::join(same, ", "));
}

// An error says what the file was taken for, and how else it comes here.
PointRecording ReadAs(const PointFormat& format, const fs::path& path, ReadOptions options) {
  const bool is_in_px = format.Is(kNoUnit) && options.mm_per_unit == kInPixels;
  if (is_in_px) options.mm_per_unit = 1;
  PointRecording points;
  try {
    points = format.read(path, options);
  } catch (const UsageError&) {
    throw;
  } catch (const Error& error) {
    if (format.Is(kEstimates)) throw;  // lake's own
    throw Fail("{}; it is taken for {}: export it anew from the program that wrote it, or from there as TRC or C3D",
               error.what(), format.name);
  }
  if (!is_in_px) return points;
  points.space = PointSpace::kImage;
  for (PointTrack& point : points.points)
    for (Eigen::Vector3d& p : point.positions) p = {p.x() - kPixelCentre, -p.y() - kPixelCentre, 0};
  return points;
}

const PointFormat& ExportFormat(const std::string& name) {
  for (const PointFormat& format : kFormats)
    if (!name.empty() && format.export_name == name) return format;
  throw UsageError("--export {}: not a format; there are {}", name, fmt::join(ExportFormats(), ", "));
}

}  // namespace

const PointFormat& FormatOfFile(const fs::path& path) {
  if (fs::is_fifo(path)) return FormatOf(path);  // it is read once
  const std::string name = Lower(path.filename().string()), head = FirstLineOf(path), line = Lower(head);
  for (const PointFormat& format : kFormats)
    if (HasEnding(format, name) && line.find(format.mark) != line.npos) return format;
  ThrowUnknown(path, name, head);
}

const PointFormat& FormatOf(const fs::path& path) {
  const std::string name = Lower(path.filename().string());
  for (const PointFormat& format : kFormats)
    if (format.write && name.ends_with(format.written_ending)) return format;
  throw UsageError("{}: .trc, .c3d, .txt (Tracker), .trk, .csv (lake), _kinovea.csv or .kva can be written",
                   path.string());
}

std::string ReadableEndings() {
  std::vector<std::string> endings;
  for (const PointFormat& format : kFormats)
    for (const char* ending : format.endings)
      if (ending && std::ranges::find(endings, ending) == endings.end()) endings.emplace_back(ending);
  return fmt::format("{}", fmt::join(endings, ", "));
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

PointRecording ReadPoints(const fs::path& path, const ReadOptions& options) {
  if (const std::vector<fs::path> files = MarkerFilesOf(path); !files.empty()) return ReadMarkerFiles(files, options);
  if (fs::is_directory(path)) return ReadOwnPoints(TableOfFolder(path), options);
  if (!fs::exists(path)) throw Fail("{}: no such file", path.string());
  const PointFormat& format = FormatOfFile(path);
  if (format.Is(kNoTimes) && !(options.rate_hz > 0))
    throw UsageError("{}: tables of {} have no times: give the frame rate (lake convert --rate HZ)", path.string(),
                     format.name);
  return ReadAs(format, path, options);
}

void WritePoints(const fs::path& path, const PointRecording& points, const std::string& unit) {
  const PointFormat& format = FormatOf(path);
  const auto& [trait, refusal] = kOfSpaces[static_cast<int>(points.space)];
  if (!format.Is(trait)) throw Fail("{}: {}", path.string(), refusal);
  if (format.write == WriteTrcInMm) return WriteTrc(path, points, unit);
  if (unit != "mm") throw UsageError("{}: is always in mm; only .trc can be in {}", path.string(), unit);
  format.write(path, points);
}

std::vector<std::string> ExportFormats() {
  std::vector<std::string> names = {kAngles};
  for (const PointFormat& format : kFormats)
    if (*format.export_name) names.emplace_back(format.export_name);
  return names;
}

void CheckExportFormats(const std::vector<std::string>& formats, bool has_scale, bool has_leg) {
  for (const std::string& format : formats) {
    if (format != kAngles && !has_scale && !ExportFormat(format).Is(kHoldsImage))
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
  return name + (format == "tracker" ? "_tracker" : "") + ExportFormat(format).written_ending;
}

void ExportTrial(const std::string& format, const fs::path& path, const ExportedTrial& trial) {
  CheckExportFormats({format}, trial.points.space != PointSpace::kImage, trial.motion != nullptr);
  if (format == kAngles && trial.motion) return WriteMot(path, MotFromLegMotion(*trial.motion, trial.leg));
  const PointFormat& writer = ExportFormat(format);
  writer.write(path, writer.Is(kHoldsPlane) ? trial.points : trial.image);
}

}  // namespace lake::exchange
