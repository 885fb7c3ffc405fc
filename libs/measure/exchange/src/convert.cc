#include "lake/exchange/convert.h"

#include "lake/camera/camera.h"
#include "lake/core/error.h"
#include "lake/core/run.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/mot.h"
#include "readers.h"

namespace lake::exchange {
namespace {

namespace fs = std::filesystem;

// Of the frames whose times are kept: the first, and the one behind the last.
struct FrameRange {
  std::size_t begin = 0, end = 0;

  template <typename List>
  void Keep(List& list) const {
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(end), list.end());
    list.erase(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(begin));
  }
};

FrameRange FindRange(const std::array<double, 2>& crop_s, const fs::path& path, const std::vector<double>& time_s) {
  FrameRange range{0, time_s.size()};
  while (range.begin < range.end && time_s[range.begin] < crop_s[0]) ++range.begin;
  while (range.end > range.begin && time_s[range.end - 1] > crop_s[1]) --range.end;
  if (range.begin == range.end)
    throw Fail("{}: nothing lies between {} and {} s{}", path.string(), crop_s[0], crop_s[1],
               time_s.empty() ? ""
                              : fmt::format("; it lasts from {} to {} s", SignificantText(time_s.front(), 6),
                                            SignificantText(time_s.back(), 6)));
  return range;
}

void CropPoints(const std::array<double, 2>& crop_s, const fs::path& path, PointRecording& points) {
  const FrameRange range = FindRange(crop_s, path, points.time_s);
  for (PointTrack& point : points.points) range.Keep(point.positions);
  for (ModelOutput& output : points.outputs) range.Keep(output.positions);
  range.Keep(points.frame);
  range.Keep(points.time_s);
  std::erase_if(points.events, [&](const PointEvent& e) { return e.time_s < crop_s[0] || e.time_s > crop_s[1]; });
}

void CropTable(const std::array<double, 2>& crop_s, const fs::path& path, MotTable& table) {
  const FrameRange range = FindRange(crop_s, path, table.time_s);
  range.Keep(table.rows);
  range.Keep(table.time_s);
}

void CheckNoPointOptions(const fs::path& out, const ConvertOptions& options, const char* what = "angles") {
  const TrialOptions& reading = options.reading;
  if (!reading.names.empty() || reading.up || !reading.forward.empty() || options.unit != "mm" ||
      reading.mm_per_unit != 1 || reading.rate_hz > 0 || reading.values == motion::MarkerValues::kEstimated ||
      options.picture.IsGiven())
    throw UsageError(
        "{}: holds {}: --map, --up, --forward, --unit, --camera, --scale, --rate, --smoothed and --out-unit are "
        "for points",
        out.string(), what);
}

// Which leg the program that wrote a kinematics.csv took it for, as its summary says.
std::optional<motion::Side> LegOfSummary(const fs::path& kinematics) {
  const fs::path file = kinematics.parent_path() / "summary.json";
  if (kinematics.filename() != "kinematics.csv" || !fs::is_regular_file(file)) return std::nullopt;
  return LegInSummary(ReadJsonFile(file));
}

motion::Side LegOf(const fs::path& kinematics, const ConvertOptions& options) {
  if (const std::optional<motion::Side> leg = options.leg ? options.leg : LegOfSummary(kinematics)) return *leg;
  throw UsageError("{}: does not say whether this is the left or the right leg: give --leg", kinematics.string());
}

// None where there is no events.csv; whose foot strikes has to be known.
std::vector<PointEvent> EventsOfFolder(const fs::path& folder, const ConvertOptions& options) {
  if (!fs::is_regular_file(folder / "events.csv")) return {};
  const std::vector<motion::StsEvent> events = motion::ReadEventsCsv(folder / "events.csv");
  const bool is_walk = std::ranges::any_of(
      events, [](const motion::StsEvent& event) { return event.kind >= motion::StsEventKind::kHeelStrike; });
  return PointEvents(events, is_walk ? LegOf(folder / "kinematics.csv", options) : motion::Side::kRight);
}

std::vector<std::string> ConvertAngles(const fs::path& in, const fs::path& out, const ConvertOptions& options) {
  CheckNoPointOptions(out, options);
  MotTable table;
  if (IsMot(in)) {
    if (options.flexion_negative)
      throw UsageError("--flexion-negative is for kinematics.csv; the sign of a .mot stays as it is");
    if (options.leg) throw UsageError("--leg is for kinematics.csv; the columns of a .mot keep their names");
    table = ReadMot(in);
  } else {
    const fs::path kinematics = fs::is_directory(in) ? in / "kinematics.csv" : in;
    if (Lower(kinematics.extension().string()) != ".csv")
      throw Fail("{}: holds points, and {} angles: run lake gait first and convert its folder", in.string(),
                 out.filename().string());
    table =
        MotFromLegMotion(motion::ReadKinematicsCsv(kinematics), LegOf(kinematics, options), options.flexion_negative);
  }
  if (options.crop_s) CropTable(*options.crop_s, in, table);
  WriteMot(out, table);
  return table.warnings;
}

// Positions in px as `picture` scales them: in mm, or, in a project over the video, in px beside the scale.
PointRecording ScaledBy(gait::PictureScale picture, PointRecording points, const fs::path& in, const fs::path& table,
                        const fs::path& out) {
  picture.pixel_aspect = PixelAspectBeside(table);
  const auto refuse = [&](const fs::path& file, const char* why) {
    CheckNoneIsUnused(file, {{picture.OptionName(), why}});
  };
  if (points.space != PointSpace::kImage) refuse(in, "its lengths are in mm");
  const PointFormat& format = FormatOf(out);
  if (!format.Is(kHoldsPlane) && !picture.scale) refuse(out, "it holds px, and at most the scale of a bar");
  std::vector<std::string> warnings;
  const gait::LegView view = gait::ViewOf(picture, MarkersFromPoints(points), points.mm_per_px,
                                          [&](const std::string& text) { warnings.push_back(text); });
  points.warnings.insert(points.warnings.end(), warnings.begin(), warnings.end());
  points.mm_per_px = view.mm_per_px;
  if (!format.Is(kHoldsPlane) || PlaneUnit(view) == motion::LengthUnit::kPx) return points;
  points.space = PointSpace::kPlane;
  points.mm_per_px.reset();
  points.axes.reset();
  points.video.reset();
  for (PointTrack& point : points.points)
    for (Eigen::Vector3d& p : point.positions)
      if (p.allFinite()) p.head<2>() = gait::PlaneFromRecorded(view, p.head<2>(), 0);
  return points;
}

PointRecording FitToFormat(const PointRecording& read, const fs::path& in, const fs::path& out,
                           const ConvertOptions& options) {
  const PointFormat& format = FormatOf(out);
  PointRecording points = RenamePoints(read, options.reading.names, in);
  if (points.space == PointSpace::kImage && !format.Is(kHoldsImage)) points = PointsInPlane(points);
  if (points.space != PointSpace::kSpace && !options.reading.forward.empty())
    CheckNoneIsUnused(in, {{"--forward", "its points lie in a plane"}});
  if (points.space != PointSpace::kSpace) return points;
  if (options.reading.up) points.up_axis = *options.reading.up;
  double out_of_plane_mm = 0;
  if (!format.Is(kHoldsSpace)) return ProjectOntoSagittalPlane(read, options.reading, in, &out_of_plane_mm);
  return options.reading.forward.empty() ? points : PointsFacing(points, options.reading);
}

// Of a folder's tables the one that the format holds: positions in px for projects that lie over a video.
fs::path TableFor(const fs::path& out, const fs::path& folder) {
  const PointFormat& format = FormatOf(out);
  if (format.Is(kHoldsPlane)) return TableOfFolder(folder);
  if (const auto tracks = FindResult(folder, "tracks.csv")) return *tracks;
  throw Fail("{}: has no tracks.csv, and {} holds positions in px", folder.string(), out.filename().string());
}

// A folder's tables are in a plane; what was measured in space loses its way across.
void WarnOfProjection(const fs::path& folder, PointRecording& points) {
  const fs::path summary = folder / "summary.json";
  if (!fs::is_regular_file(summary)) return;
  const Json json = ReadJsonFile(summary);
  if (!json.is_object() || !json.contains("across_plane")) return;
  points.warnings.push_back(fmt::format(
      "{}: was measured in space, and its tables are the projection onto the vertical plane of the leg's motion: "
      "angles "
      "of what is written differ from those of kinematics.csv by degrees; convert the recording itself instead",
      folder.string()));
}

std::vector<std::string> ConvertCamera(const fs::path& in, const fs::path& out, const ConvertOptions& options) {
  CheckNoPointOptions(out, options, "a camera");
  const camera::CameraProfile profile = camera::ReadCameraProfile(in, options.reading.view);
  camera::WriteCameraProfile(out, profile);
  return profile.warnings;
}

}  // namespace

std::vector<std::string> ConvertFile(const fs::path& in, const fs::path& out, const ConvertOptions& options) {
  if (!fs::exists(in)) throw Fail("{}: no such file", in.string());
  if (fs::exists(out) && fs::equivalent(in, out)) throw UsageError("{}: is the input itself", out.string());
  const std::string ending = Lower(out.extension().string());
  if (ending == ".yaml" || ending == ".yml") return ConvertCamera(in, out, options);
  if (IsMot(out)) return ConvertAngles(in, out, options);
  FormatOf(out);  // a wrong ending is reported before a long file is read
  if (IsMot(in)) throw Fail("{}: holds angles, and {} points", in.string(), out.filename().string());
  if (options.flexion_negative || (options.leg && ending != ".c3d"))
    throw UsageError("{} is for a .mot that is written", options.leg ? "--leg" : "--flexion-negative");
  CheckNoneIsUnused(in, UnusedOptions(in, options.reading));
  const fs::path table = fs::is_directory(in) && MarkerFilesOf(in).empty() ? TableFor(out, in) : in;
  PointRecording points = ReadPoints(table, options.reading.Reading());
  if (fs::is_directory(in)) WarnOfProjection(table.parent_path(), points);
  if (ending == ".c3d" && fs::is_directory(in)) points.events = EventsOfFolder(table.parent_path(), options);
  if (options.crop_s) CropPoints(*options.crop_s, in, points);
  if (options.picture.IsGiven()) points = ScaledBy(options.picture, std::move(points), in, table, out);
  points = FitToFormat(points, in, out, options);
  if (!points.events.empty() && ending != ".c3d")
    points.warnings.push_back(
        fmt::format("{}: {} events are left out; only C3D holds them", in.string(), points.events.size()));
  if (!points.outputs.empty())
    points.warnings.push_back(fmt::format("{}: {} outputs of a model ({}, …) are left out; they are no markers",
                                          in.string(), points.outputs.size(), points.outputs.front().name));
  if (points.space == PointSpace::kImage && FormatOf(out).Is(kNoUnit))
    points.warnings.push_back(fmt::format(
        "{}: in px from the picture's top-left corner, y up, which the format does not say: read it by --unit px",
        out.string()));
  WritePoints(out, points, options.unit);
  return points.warnings;
}

void Describe(ConvertOptions& o, OptionList& options) {
  options.Add("map", o.reading.names, "Keep these markers only, under these names; A+B is the midpoint of two")
      .Value("NAME=MARKER,...");
  options.Add("forward", o.reading.forward, "Turn a 3-D trial so that this axis of the file is x, up is y, right is z")
      .Value("AXIS")
      .Otherwise("axes as they are");
  DescribeUnit("unit", o.reading.mm_per_unit, options);
  Describe(o.picture, options);
  DescribeRate(o.reading.rate_hz, options);
  DescribeReading(o.reading, options);
  using Units = OptionList::Choices<std::string>;
  options.AddChoice("out-unit", o.unit, Units{{"mm", "mm"}, {"cm", "cm"}, {"m", "m"}}, "Length unit of a .trc output");
  options.Add("crop", o.crop_s, "Keep only this time span").Unit("s").Value("START,END");
  using Sides = OptionList::Choices<motion::Side>;
  options
      .AddChoice("leg", o.leg, Sides{{"left", motion::Side::kLeft}, {"right", motion::Side::kRight}},
                 "Leg that the knee angle is of: knee_angle_l or knee_angle_r (.mot)")
      .Otherwise("the one that lake track or lake gait found");
  options.Add("flexion-negative", o.flexion_negative,
              "Write the knee angle negative in flexion, as OpenSim's older models expect (.mot)");
}

Option& DescribeRate(double& rate_hz, OptionList& options) {
  return options.Add("rate", rate_hz, "Frame rate of files without times (DLTdv, DeepLabCut, SLEAP)")
      .Unit("Hz")
      .Positive()
      .Otherwise("none");
}

}  // namespace lake::exchange
