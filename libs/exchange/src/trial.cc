#include "lake/exchange/trial.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/kinovea.h"
#include "lake/exchange/mot.h"
#include "lake/exchange/tracker.h"
#include "lake/exchange/trc.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

std::string Names(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 60;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) text += (i ? ", " : "") + names[i];
  return names.size() > kMost ? text + ", …" : text;
}

std::vector<std::string> NamesOf(const PointRecording& points) {
  std::vector<std::string> names;
  for (const PointTrack& point : points.points) names.push_back(point.name);
  return names;
}

// "A" or the middle of "A+B".
PointTrack TakePoint(const PointRecording& points, const std::string& expression, const std::string& name,
                     const fs::path& path) {
  PointTrack result{name, {}};
  const std::vector<std::string> parts = SplitText(expression, '+');
  // A name that holds a plus sign itself is taken as it is.
  const std::vector<std::string> wanted = points.Find(expression) ? std::vector<std::string>{expression} : parts;
  for (const std::string& part : wanted) {
    const PointTrack* track = points.Find(part);
    if (!track)
      throw Fail("{}: no marker '{}' (for {}); it has: {}", path.string(), part, name, Names(NamesOf(points)));
    if (result.positions.empty()) result.positions.assign(track->positions.size(), Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < track->positions.size(); ++i)
      result.positions[i] += track->positions[i] / static_cast<double>(wanted.size());
  }
  return result;
}

PointRecording Rename(const PointRecording& points, const std::map<std::string, std::string>& names,
                      const fs::path& path) {
  if (names.empty()) return points;
  PointRecording renamed = points;
  renamed.points.clear();
  for (const auto& [name, expression] : names) renamed.points.push_back(TakePoint(points, expression, name, path));
  return renamed;
}

// Lake's own tables keep sigmas and statuses.
MarkerRecording Rename(MarkerRecording markers, const std::map<std::string, std::string>& names, const fs::path& path) {
  for (const auto& [name, wanted] : names) {
    const auto found = std::find_if(markers.markers.begin(), markers.markers.end(),
                                    [&](const MarkerTrack& m) { return m.name == wanted; });
    if (found == markers.markers.end()) {
      std::vector<std::string> known;
      for (const MarkerTrack& marker : markers.markers) known.push_back(marker.name);
      throw Fail("{}: no marker '{}' (for {}); it has: {}", path.string(), wanted, name, Names(known));
    }
    found->name = name;
  }
  return markers;
}

int AxisIndex(char axis) {
  if (axis < 'x' || axis > 'z') throw UsageError(fmt::format("axis '{}': x, y or z", axis));
  return axis - 'x';
}

// "x", "+x", "-x"
Eigen::Vector3d ParseDirection(const std::string& text) {
  const bool negative = text.starts_with('-');
  const std::string axis = text.substr(negative || text.starts_with('+') ? 1 : 0);
  if (axis.size() != 1) throw UsageError(fmt::format("--forward '{}': x, y or z with a sign", text));
  return (negative ? -1.0 : 1.0) * Eigen::Vector3d::Unit(AxisIndex(axis[0]));
}

// The horizontal direction in which the segments between the leg's markers move most: their changes lie in the sagittal
// plane.
Eigen::Vector3d FitForward(const PointRecording& points, const Eigen::Vector3d& up, const fs::path& path) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& [lower, upper] : {std::pair{"ankle", "knee"}, {"knee", "hip"}}) {
    const PointTrack *a = points.Find(lower), *b = points.Find(upper);
    if (!a || !b)
      throw Fail(
          "{}: the sagittal plane is fitted to ankle, knee and hip: name them with --map, or give --forward; it has: "
          "{}",
          path.string(), Names(NamesOf(points)));
    std::vector<Eigen::Vector3d> vectors;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < a->positions.size(); ++i) {
      const Eigen::Vector3d v = b->positions[i] - a->positions[i], horizontal = v - up * up.dot(v);
      if (horizontal.allFinite()) vectors.push_back(horizontal), mean += horizontal;
    }
    if (vectors.empty()) throw Fail("{}: {} and {} are never seen together", path.string(), lower, upper);
    mean /= static_cast<double>(vectors.size());
    for (const Eigen::Vector3d& v : vectors) spread += (v - mean) * (v - mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  Eigen::Vector3d forward = solver.eigenvectors().col(2);
  forward = (forward - up * up.dot(forward)).normalized();
  if (!forward.allFinite())
    throw Fail("{}: the leg does not move; give the sagittal plane with --forward", path.string());
  Eigen::Index axis = 0;
  forward.cwiseAbs().maxCoeff(&axis);
  return forward[axis] < 0 ? Eigen::Vector3d(-forward) : forward;
}

// RMS movement of the named points across a plane.
double OutOfPlane(const PointRecording& points, const Eigen::Vector3d& normal) {
  double square = 0;
  std::size_t count = 0;
  for (const char* name : {"ankle", "knee", "hip"}) {
    const PointTrack* point = points.Find(name);
    if (!point) continue;
    double sum = 0, sum2 = 0;
    std::size_t n = 0;
    for (const Eigen::Vector3d& p : point->positions)
      if (p.allFinite()) sum += p.dot(normal), sum2 += std::pow(p.dot(normal), 2), ++n;
    if (n > 0) square += sum2 - sum * sum / static_cast<double>(n), count += n;
  }
  return count > 0 ? std::sqrt(std::max(0.0, square / static_cast<double>(count))) : 0;
}

MarkerRecording ProjectOntoPlane(const PointRecording& points, const TrialOptions& options, Trial& trial) {
  const Eigen::Vector3d up = Eigen::Vector3d::Unit(AxisIndex(options.up.value_or(points.up_axis)));
  Eigen::Vector3d forward;
  if (options.forward.empty()) {
    forward = FitForward(points, up, trial.file);
  } else {
    forward = ParseDirection(options.forward);
    if (std::abs(forward.dot(up)) > 0.5)
      throw UsageError(fmt::format("--forward '{}' is the vertical; give --up too", options.forward));
    trial.faces_right = true;
  }
  trial.out_of_plane_mm = OutOfPlane(points, forward.cross(up));
  PointRecording plane = points;
  plane.space = PointSpace::kPlane;
  for (PointTrack& point : plane.points)
    for (Eigen::Vector3d& p : point.positions)
      if (p.allFinite()) p = {p.dot(forward), p.dot(up), 0};
  return MarkersFromPoints(plane);
}

void ReadTable(const fs::path& path, const TrialOptions& options, Trial& trial) {
  trial.recording = Rename(ReadMarkerCsv(path), options.names, path);
}

fs::path FileOfFolder(const fs::path& folder) {
  for (const char* name : {"trajectory.csv", "tracks.csv"})
    if (fs::is_regular_file(folder / name)) return folder / name;
  throw Fail("{}: the folder has neither trajectory.csv nor tracks.csv; is it one that lake-track wrote?",
             folder.string());
}

bool IsOwnTable(const fs::path& path) {
  return path.extension() == ".csv" && !IsKinovea(path);
}

}  // namespace

std::map<std::string, std::string> ParseNameMap(const std::string& text) {
  std::map<std::string, std::string> names;
  for (const std::string& part : SplitText(text, ',')) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == part.size())
      throw UsageError(fmt::format("--map '{}': '{}' is not NAME=MARKER", text, part));
    if (!names.emplace(part.substr(0, equals), part.substr(equals + 1)).second)
      throw UsageError(fmt::format("--map '{}': '{}' stands twice", text, part.substr(0, equals)));
  }
  return names;
}

PointRecording ReadPoints(const fs::path& path, double mm_per_unit) {
  if (fs::is_directory(path)) return PointsFromMarkers(ReadMarkerCsv(FileOfFolder(path)));
  if (!fs::exists(path)) throw Fail("{}: no such file", path.string());
  const std::string extension = path.extension().string();
  if (extension == ".trc") return ReadTrc(path);
  if (extension == ".c3d") return ReadC3d(path);
  if (extension == ".trk") return ReadTrk(path);
  if (extension == ".txt") return ReadTrackerText(path, mm_per_unit);
  if (extension == ".csv")
    return IsKinovea(path) ? ReadKinovea(path, mm_per_unit) : PointsFromMarkers(ReadMarkerCsv(path));
  throw Fail("{}: unknown kind of file; .trc, .c3d, .trk, .txt (Tracker), .csv (lake, Kinovea) are known",
             path.string());
}

Trial ReadTrial(const fs::path& path, const TrialOptions& options) {
  Trial trial;
  trial.file = fs::is_directory(path) ? FileOfFolder(path) : path;
  if (IsOwnTable(trial.file) && fs::exists(trial.file)) {
    ReadTable(trial.file, options, trial);
  } else {
    const PointRecording points = Rename(ReadPoints(trial.file, options.mm_per_unit), options.names, trial.file);
    trial.mm_per_px = points.mm_per_px;
    trial.recording =
        points.space == PointSpace::kSpace ? ProjectOntoPlane(points, options, trial) : MarkersFromPoints(points);
  }
  if (!options.forward.empty() && !trial.faces_right) {
    const Eigen::Vector3d forward = ParseDirection(options.forward);
    if (forward.x() == 0) throw UsageError(fmt::format("--forward '{}': in a plane it is +x or -x", options.forward));
    trial.faces_right = forward.x() > 0;
  }
  return trial;
}

void WritePoints(const fs::path& path, const PointRecording& points) {
  const std::string extension = path.extension().string();
  if (extension == ".trc") return WriteTrc(path, points);
  if (extension == ".c3d") return WriteC3d(path, points);
  if (extension == ".txt") return WriteTrackerText(path, points);
  if (path.filename().string().ends_with("_kinovea.csv")) return WriteKinovea(path, points);
  if (extension == ".csv") return WriteMarkerCsv(path, MarkersFromPoints(points));
  throw UsageError(
      fmt::format("{}: .trc, .c3d, .txt (Tracker), .csv (lake) or _kinovea.csv can be written", path.string()));
}

std::vector<fs::path> ExportTrial(const std::vector<std::string>& formats, const fs::path& folder,
                                  const std::string& name, const PointRecording& points, const LegMotion* motion) {
  static constexpr std::array<std::pair<const char*, const char*>, 4> kFiles = {
      {{"trc", ".trc"}, {"c3d", ".c3d"}, {"tracker", "_tracker.txt"}, {"kinovea", "_kinovea.csv"}}};
  std::vector<fs::path> written;
  for (const std::string& format : formats) {
    const auto found =
        std::find_if(kFiles.begin(), kFiles.end(), [&](const auto& file) { return format == file.first; });
    if (found != kFiles.end()) {
      written.push_back(folder / (name + found->second));
      WritePoints(written.back(), points);
    } else if (format == "mot") {
      if (!motion) throw Fail("export: a MOT file needs the leg's angles, which this recording does not give");
      written.push_back(folder / (name + ".mot"));
      WriteMot(written.back(), MotFromLegMotion(*motion));
    } else {
      throw UsageError(fmt::format("export '{}': trc, mot, c3d, tracker or kinovea", format));
    }
  }
  return written;
}

}  // namespace lake
