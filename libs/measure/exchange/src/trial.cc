#include "lake/exchange/trial.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/nearest_name.h"
#include "lake/core/statistics.h"
#include "lake/motion/saved_corrections.h"
#include "readers.h"

namespace lake::exchange {
namespace {

namespace fs = std::filesystem;

std::string Listed(const std::vector<std::string>& names) {
  const std::size_t shown = std::min<std::size_t>(names.size(), 60);
  return fmt::format("{}{}", fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
                     shown < names.size() ? ", …" : "");
}

std::vector<std::string> NamesOf(const auto& tracks) {
  std::vector<std::string> names;
  names.reserve(tracks.size());
  for (const auto& track : tracks) names.push_back(track.name);
  return names;
}

// The mean of one place and `count` others whose mean is known.
Eigen::Vector3d WithAnother(const Eigen::Vector3d& mean, double count, const Eigen::Vector3d& other) {
  return (count * mean + other) / (count + 1);
}

// It is seen where all are; their errors are their own.
motion::MarkerSample WithAnother(const motion::MarkerSample& mean, double count, const motion::MarkerSample& other) {
  if (!mean.IsKnown() || !other.IsKnown()) return {};
  const auto is_seen = [](const motion::MarkerSample& sample) {
    return sample.status == motion::SampleStatus::kDetected;
  };
  return {(count * mean.position + other.position) / (count + 1),
          std::hypot(count * mean.sigma, other.sigma) / (count + 1),
          is_seen(mean) && is_seen(other) ? motion::SampleStatus::kDetected : motion::SampleStatus::kFilled};
}

// What a list of tracks has of "A", or the mean of "A+B+…"; a name that holds a plus sign itself is taken as it is.
auto TakeFrom(const auto& tracks, auto values, const std::string& expression, const std::string& name,
              const fs::path& path) {
  const std::vector<std::string> known = NamesOf(tracks), parts = SplitText(expression, '+');
  const auto find = [&](const std::string& part) -> const auto& {
    const auto at = std::ranges::find(known, part);
    if (at != known.end()) return tracks[static_cast<std::size_t>(at - known.begin())].*values;
    throw Fail("{}: no marker '{}' (for {}){}; it has: {}", path.string(), part, name, DidYouMean(part, known),
               Listed(known));
  };
  if (parts.size() < 2 || std::ranges::find(known, expression) != known.end()) return find(expression);
  auto mean = find(parts[0]);
  for (std::size_t part = 1; part < parts.size(); ++part) {
    const auto& other = find(parts[part]);
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = WithAnother(mean[i], static_cast<double>(part), other[i]);
  }
  return mean;
}

// Markers that nothing is said of keep their names, unless another gets theirs.
motion::MarkerRecording Rename(const motion::MarkerRecording& markers, const std::map<std::string, std::string>& names,
                               const fs::path& path) {
  motion::MarkerRecording renamed = markers;
  std::erase_if(renamed.markers, [&](const motion::MarkerTrack& marker) {
    return names.contains(marker.name) ||
           std::ranges::any_of(names, [&](const auto& name) { return name.second == marker.name; });
  });
  for (const auto& [name, wanted] : names)
    renamed.markers.push_back({name, TakeFrom(markers.markers, &motion::MarkerTrack::samples, wanted, name, path)});
  return renamed;
}

constexpr const char* kLeg[] = {"ankle", "knee", "hip"};

int AxisIndex(char axis) {
  if (axis < 'x' || axis > 'z')
    throw UsageError("axis '{}': must be x, y or z, with - for the opposite direction", axis);
  return axis - 'x';
}

// "x", "+x", "-x"
Eigen::Vector3d ParseDirection(const std::string& text) {
  const bool negative = text.starts_with('-');
  const std::string axis = text.substr(negative || text.starts_with('+') ? 1 : 0);
  if (axis.size() != 1) throw UsageError("--forward '{}': x, y or z with a sign", text);
  return (negative ? -1.0 : 1.0) * Eigen::Vector3d::Unit(AxisIndex(axis[0]));
}

// The horizontal direction in which the segments between the leg's markers move most: their changes lie in the sagittal
// plane.
Eigen::Vector3d FitForward(const PointRecording& points, const Eigen::Vector3d& up, const fs::path& path) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  double lengths_mm2 = 0;
  for (const auto& [lower, upper] : {std::pair{"ankle", "knee"}, {"knee", "hip"}}) {
    const PointTrack *a = points.Find(lower), *b = points.Find(upper);
    if (!a || !b)
      throw Fail(
          "{}: the sagittal plane is fitted to ankle, knee and hip: name them with --map, or give --forward; it has: "
          "{}",
          path.string(), Listed(NamesOf(points.points)));
    std::vector<Eigen::Vector3d> vectors;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < a->positions.size(); ++i) {
      const Eigen::Vector3d v = b->positions[i] - a->positions[i], horizontal = v - up * up.dot(v);
      if (horizontal.allFinite()) {
        vectors.push_back(horizontal);
        mean += horizontal;
        lengths_mm2 += v.squaredNorm();
      }
    }
    if (vectors.empty()) throw Fail("{}: {} and {} are never seen together", path.string(), lower, upper);
    mean /= static_cast<double>(vectors.size());
    for (const Eigen::Vector3d& v : vectors) spread += (v - mean) * (v - mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  constexpr double kRounding = 1e-12;  // of floats, squared
  if (!(solver.eigenvalues()[2] > kRounding * lengths_mm2))
    throw Fail("{}: the leg does not move; give the sagittal plane with --forward", path.string());
  Eigen::Vector3d forward = solver.eigenvectors().col(2);
  forward = (forward - up * up.dot(forward)).normalized();
  Eigen::Index axis = 0;
  forward.cwiseAbs().maxCoeff(&axis);
  return forward[axis] < 0 ? Eigen::Vector3d(-forward) : forward;
}

// RMS movement of the leg's points across a plane.
double OutOfPlane(const PointRecording& points, const Eigen::Vector3d& normal) {
  std::vector<double> moved_mm;
  for (const char* name : kLeg) {
    const PointTrack* point = points.Find(name);
    if (!point) continue;
    std::vector<double> across_mm;
    for (const Eigen::Vector3d& p : point->positions)
      if (p.allFinite()) across_mm.push_back(p.dot(normal));
    const double mean_mm = across_mm.empty() ? 0 : Mean(across_mm);
    for (const double at_mm : across_mm) moved_mm.push_back(at_mm - mean_mm);
  }
  return moved_mm.empty() ? 0 : RootMeanSquare(moved_mm);
}

// What `lake track` knew of the measurements' sigmas.
void TakeSigmasFrom(const Json& summary, const fs::path& file, Trial& trial) {
  const Json::json_pointer known("/fit/known_sigmas"), lasting("/fit/lasting_share");
  trial.known_sigmas = summary.contains(known) && summary[known] == Json(true);
  if (!summary.contains(lasting)) return;
  const Json& share = summary[lasting];
  if (!share.is_number() || share < 0 || share > 1) throw Fail("{}: 'lasting_share' is not 0 to 1", file.string());
  trial.lasting_share = share;
}

// Where the picture or the plane does not stand upright, the summary beside a folder's tables says what is up in them;
// it also says what is known of the measurements' sigmas.
void TakeFromSummary(const fs::path& table, motion::MarkerValues values, Trial& trial) {
  constexpr const char* kUp = "up_in_plane";
  const fs::path file = table.parent_path() / "summary.json";
  const bool in_mm = fs::exists(table.parent_path() / "trajectory.csv");
  if (table.filename() != (in_mm ? "trajectory.csv" : "tracks.csv") || !fs::is_regular_file(file)) return;
  if (std::string unapplied = motion::UnappliedCorrections(table.parent_path()); !unapplied.empty())
    trial.warnings.push_back(std::move(unapplied));
  const Json summary = ReadJsonFile(file);
  if (values == motion::MarkerValues::kMeasured) TakeSigmasFrom(summary, file, trial);
  trial.leg = LegInSummary(summary);
  if (in_mm) trial.sight = gait::PlaneSightIn(summary, file.string());
  if (!summary.contains(kUp)) return;
  const Json& said = summary[kUp];
  const bool is_pair = said.is_array() && said.size() == 2 && said[0].is_number() && said[1].is_number();
  const Eigen::Vector2d up = is_pair ? Eigen::Vector2d(said[0], said[1]) : Eigen::Vector2d::Zero();
  if (!(std::abs(up.norm() - 1) < 1e-6)) throw Fail("{}: '{}' is no unit vector", file.string(), kUp);
  trial.up = up;
}

// The side that the file's names of ankle, knee and hip begin with, where they agree.
std::optional<motion::Side> SideOfLegMarkers(const std::map<std::string, std::string>& names) {
  std::optional<motion::Side> side;
  for (const char* name : kLeg) {
    const auto found = names.find(name);
    const auto of_marker = found == names.end() ? std::nullopt : motion::SideOfName(found->second);
    if (!of_marker || (side && side != of_marker)) return std::nullopt;
    side = of_marker;
  }
  return side;
}

void ReadOwnTable(const fs::path& path, const TrialOptions& options, Trial& trial) {
  trial.recording = Rename(exchange::ReadTable(path, options.values), options.names, path);
  TakeFromSummary(path, options.values, trial);
  if (trial.recording.unit == motion::LengthUnit::kPx) trial.pixel_aspect = PixelAspectBeside(path);
}

Eigen::Vector3d UpDirection(const PointRecording& points, const TrialOptions& options) {
  return Eigen::Vector3d::Unit(AxisIndex(options.up.value_or(points.up_axis)));
}

Eigen::Vector3d GivenForward(const TrialOptions& options, const Eigen::Vector3d& up) {
  const Eigen::Vector3d forward = ParseDirection(options.forward);
  if (std::abs(forward.dot(up)) > 0.5)
    throw UsageError("--forward '{}' is the vertical; give --up too", options.forward);
  return forward;
}

struct SagittalAxes {
  Eigen::Vector3d forward, up;
  Eigen::Vector3d Across() const { return forward.cross(up); }
  Eigen::Matrix3d PlaneFromSpace() const {
    Eigen::Matrix3d rows;
    rows << forward.transpose(), up.transpose(), Across().transpose();
    return rows;
  }
};

SagittalAxes FindSagittalAxes(const PointRecording& points, const TrialOptions& options, const fs::path& path) {
  const Eigen::Vector3d up = UpDirection(points, options);
  return {options.forward.empty() ? FitForward(points, up, path) : GivenForward(options, up), up};
}

// A knee of two markers across the movement is one of a lateral and a medial marker, and their line the axis that it
// bends about: the plane across it instead, vertical. Nullopt for a knee of one marker, or of two along the movement.
std::optional<SagittalAxes> AxesAcrossKnee(const PointRecording& points, const TrialOptions& options,
                                           const SagittalAxes& axes) {
  constexpr double kMostYaw_deg = 40;  // of a knee's axis against the movement's plane; markers showed up to 18
  const auto knee = options.names.find("knee");
  if (knee == options.names.end() || points.Find(knee->second)) return std::nullopt;
  const std::vector<std::string> parts = SplitText(knee->second, '+');
  if (parts.size() != 2) return std::nullopt;
  const PointTrack *a = points.Find(parts[0]), *b = points.Find(parts[1]);
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < a->positions.size(); ++i) {
    const Eigen::Vector3d v = b->positions[i] - a->positions[i];
    if (v.allFinite()) along += v - axes.up * axes.up.dot(v);
  }
  const Eigen::Vector3d forward = axes.up.cross(along).normalized();
  const double cosine = forward.dot(axes.forward);
  if (!(std::abs(cosine) > std::cos(RadiansFromDegrees(kMostYaw_deg)))) return std::nullopt;
  return SagittalAxes{cosine < 0 ? Eigen::Vector3d(-forward) : forward, axes.up};
}

struct SagittalPlane {
  SagittalAxes axes;
  std::string name;  // which plane that is
};

// Of the points as `read`, and of those that the names say.
SagittalPlane FindSagittalPlane(const PointRecording& read, const PointRecording& named, const TrialOptions& options,
                                const fs::path& path) {
  if (const auto& given = options.plane_from_space)
    return {{given->row(0).transpose(), given->row(1).transpose()}, "of the trial that it is held against"};
  const SagittalAxes axes = FindSagittalAxes(named, options, path);
  if (const auto across = AxesAcrossKnee(read, options, axes))
    return {*across, "across the knee's axis, as " + options.names.at("knee") + " show it"};
  return {axes, options.forward.empty() ? "in which the leg moves most" : "along " + options.forward};
}

PointRecording Project(const PointRecording& points, const SagittalPlane& onto, const fs::path& path,
                       double* out_of_plane_mm) {
  *out_of_plane_mm = OutOfPlane(points, onto.axes.Across());
  PointRecording plane = points;
  plane.space = PointSpace::kPlane;
  for (PointTrack& point : plane.points)
    for (Eigen::Vector3d& p : point.positions)
      if (p.allFinite()) p = {p.dot(onto.axes.forward), p.dot(onto.axes.up), 0};
  std::string warning = fmt::format("{}: paths are projected onto the vertical plane {}", path.string(), onto.name);
  if (std::ranges::any_of(kLeg, [&](const char* name) { return points.Find(name) != nullptr; }))
    warning += fmt::format("; the leg moves {:.1f} mm RMS out of it", *out_of_plane_mm);
  plane.warnings.push_back(std::move(warning));
  return plane;
}

// Empty where all points lie in one plane: such a file was made of a plane's points.
std::map<std::string, std::vector<double>> LateralPlaces(const PointRecording& points, const SagittalAxes& axes) {
  constexpr double kSamePlane_mm = 1e-6;
  std::map<std::string, std::vector<double>> lateral;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const PointTrack& point : points.points)
    for (const Eigen::Vector3d& p : point.positions) {
      const double value = p.dot(axes.Across());
      lateral[point.name].push_back(value);
      if (std::isfinite(value)) {
        least = std::min(least, value);
        most = std::max(most, value);
      }
    }
  if (most - least <= kSamePlane_mm) lateral.clear();
  return lateral;
}

bool IsOwnTable(const fs::path& path) {
  return fs::is_regular_file(path) && FormatOfFile(path).Is(kEstimates);
}

// The format of a file, of the table in a folder that lake wrote, or of a folder's first marker.
const PointFormat& FormatOfTrial(const fs::path& path) {
  if (const std::vector<fs::path> files = MarkerFilesOf(path); !files.empty()) return FormatOfFile(files.front());
  return FormatOfFile(fs::is_directory(path) ? TableOfFolder(path) : path);
}

}  // namespace

Option& DescribeUnit(const std::string& name, double& mm_per_unit, OptionList& options) {
  const auto set = [&mm_per_unit](const OptionTexts& texts, const std::string& said) {
    CheckTextCount(texts, 1, said);
    const std::optional<double> unit = FindMmPerUnit(texts.front());
    const std::optional<double> mm = unit ? unit : ParseNumber(texts.front());
    const bool is_px = Lower(texts.front()) == "px";
    if (!is_px && (!mm || !(*mm > 0)))
      throw UsageError("{} '{}': mm, cm, m, px or its length in mm", said, texts.front());
    mm_per_unit = is_px ? kInPixels : *mm;
  };
  const auto text = [&mm_per_unit] {
    return mm_per_unit == kInPixels ? "px" : mm_per_unit == 1 ? "mm" : FormatNumber(mm_per_unit);
  };
  return options
      .AddCustom(name,
                 "Unit of files that state none (Tracker text, Kinovea's CSV): mm, cm, m, its length in mm, or px, "
                 "with y up",
                 set, text)
      .Value("mm|cm|m|MM|px");
}

void Describe(TrialOptions& o, OptionList& options) {
  options
      .Add("map", o.names,
           "Each marker's name in the file; A+B is the midpoint of two, for a knee its lateral and medial marker")
      .Value("NAME=MARKER,...");
  options.Add("forward", o.forward, "Direction in which the subject of a 3-D file faces: +x, -x, …")
      .Value("AXIS")
      .Otherwise("found from the movement");
  DescribeUnit("unit", o.mm_per_unit, options);
  DescribeReading(o, options);
}

Option& DescribeView(std::string& view, OptionList& options) {
  return options.Add("view", view, "Camera of a file that holds several (DLTdv; camera files)")
      .Value("NAME")
      .Otherwise("all");
}

void DescribeReading(TrialOptions& o, OptionList& options) {
  options
      .AddChoice("up", o.up, OptionList::Choices<char>{{"x", 'x'}, {"y", 'y'}, {"z", 'z'}},
                 "Vertical axis of a 3-D file")
      .Otherwise("TRC y, C3D its own or z");
  options.AddFlag("smoothed", o.values, motion::MarkerValues::kEstimated,
                  "Start from the fit's estimates of a trajectory.csv, not from the measurements");
  DescribeView(o.view, options);
}

std::vector<UnusedOption> UnusedOptions(const fs::path& path, const TrialOptions& options) {
  if (!fs::exists(path)) return {};
  const PointFormat& format = FormatOfTrial(path);
  std::vector<UnusedOption> unused;
  const auto add = [&](bool is_unused, const char* option, const char* why) {
    if (is_unused) unused.push_back({option, why});
  };
  add(options.mm_per_unit != 1 && !format.Is(kNoUnit), "--unit", "it is in mm or px, or states its unit itself");
  add(options.up && !format.Is(kInSpace), "--up", "its points lie in a plane, with y as the vertical");
  add(options.rate_hz > 0 && !format.Is(kNoTimes), "--rate", "it has times of its own");
  add(options.values == motion::MarkerValues::kEstimated && !format.Is(kEstimates), "--smoothed",
      "it holds no fit's estimates");
  return unused;
}

void CheckNoneIsUnused(const fs::path& path, const std::vector<UnusedOption>& unused) {
  if (!unused.empty())
    throw UsageError("{} has no effect on {}: {}; leave it out", unused.front().option, path.string(),
                     unused.front().why);
}

double PixelAspectBeside(const fs::path& table) {
  static const Json::json_pointer kAspect("/video/pixel_aspect");
  const fs::path file = table.parent_path() / "summary.json";
  if (table.filename() != "tracks.csv" || !fs::is_regular_file(file)) return 1;
  const Json summary = ReadJsonFile(file);
  if (!summary.contains(kAspect)) return 1;
  const Json& aspect = summary[kAspect];
  if (!aspect.is_number() || !(aspect > 0)) throw Fail("{}: 'pixel_aspect' is not a positive number", file.string());
  return aspect;
}

std::optional<motion::Side> LegInSummary(const Json& summary) {
  for (const motion::Side side : {motion::Side::kLeft, motion::Side::kRight})
    if (summary.contains(kLegKey) && summary[kLegKey] == Json(ToString(side))) return side;
  return std::nullopt;
}

PointRecording PointsFacing(const PointRecording& points, const TrialOptions& options) {
  const Eigen::Vector3d up = UpDirection(points, options);
  const Eigen::Matrix3d model_from_file = SagittalAxes{GivenForward(options, up), up}.PlaneFromSpace();
  PointRecording facing = points;
  facing.up_axis = 'y';
  for (PointTrack& point : facing.points)
    for (Eigen::Vector3d& p : point.positions) p = model_from_file * p;
  return facing;
}

PointRecording RenamePoints(const PointRecording& points, const std::map<std::string, std::string>& names,
                            const fs::path& path) {
  if (names.empty()) return points;
  PointRecording renamed = points;
  renamed.points.clear();
  for (const auto& [name, expression] : names)
    renamed.points.push_back({name, TakeFrom(points.points, &PointTrack::positions, expression, name, path)});
  return renamed;
}

PointRecording ProjectOntoSagittalPlane(const PointRecording& read, const TrialOptions& options, const fs::path& path,
                                        double* out_of_plane_mm) {
  const PointRecording points = RenamePoints(read, options.names, path);
  const SagittalPlane plane = FindSagittalPlane(read, points, options, path);
  return Project(points, plane, path, out_of_plane_mm);
}

Trial ReadTrial(const fs::path& path, const TrialOptions& options) {
  Trial trial;
  trial.file = fs::is_directory(path) && MarkerFilesOf(path).empty() ? TableOfFolder(path) : path;
  if (IsOwnTable(trial.file)) {
    ReadOwnTable(trial.file, options, trial);
  } else {
    const PointRecording read = ReadPoints(trial.file, options.Reading());
    PointRecording points = RenamePoints(read, options.names, trial.file);
    if (points.axes) points = PointsInPlane(points);
    if (points.space == PointSpace::kSpace) {
      const SagittalPlane plane = FindSagittalPlane(read, points, options, trial.file);
      trial.plane_from_space = plane.axes.PlaneFromSpace();
      trial.lateral_mm = LateralPlaces(points, plane.axes);
      points = Project(points, plane, trial.file, &trial.out_of_plane_mm);
      if (!options.forward.empty()) trial.faces_right = true;
    }
    trial.mm_per_px = points.mm_per_px;
    trial.outputs = points.outputs;
    trial.warnings = points.warnings;
    trial.recording = MarkersFromPoints(points);
  }
  if (const auto side = SideOfLegMarkers(options.names)) trial.leg = side;
  if (!options.forward.empty() && !trial.faces_right) {
    const Eigen::Vector3d forward = ParseDirection(options.forward);
    if (forward.x() == 0) throw UsageError("--forward '{}': in a plane it is +x or -x", options.forward);
    trial.faces_right = forward.x() > 0;
  }
  return trial;
}

}  // namespace lake::exchange
