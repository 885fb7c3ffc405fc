#include "lake/commands/axis.h"

#include <fmt/ranges.h>

#include <cmath>

#include "lake/commands/functional_knee.h"
#include "lake/commands/gait.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/plausible.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/convert.h"
#include "lake/exchange/formats.h"
#include "lake/figure/trial_figures.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr const char* kCoordinates[] = {"x", "y", "z"};

exchange::PointRecording ReadMarkers(const AxisRunOptions& options) {
  exchange::TrialOptions reading;
  reading.mm_per_unit = options.mm_per_unit;
  reading.rate_hz = options.rate_hz;
  exchange::CheckNoneIsUnused(options.trial, exchange::UnusedOptions(options.trial, reading));
  return exchange::PointsInPlane(
      exchange::ReadPoints(options.trial, {.mm_per_unit = options.mm_per_unit, .rate_hz = options.rate_hz}));
}

std::size_t WindowFrames(const AxisRunOptions& options, const exchange::PointRecording& points) {
  if (options.window_s == 0) return 0;
  const double frames = std::round(options.window_s * exchange::FrameRate(points.time_s));
  if (frames < 1 || frames > static_cast<double>(points.time_s.size()))
    throw Fail("--window {}: the recording has {} frames at {} Hz; give a shorter window", options.window_s,
               points.time_s.size(), SignificantText(exchange::FrameRate(points.time_s), 4));
  return static_cast<std::size_t>(frames);
}

// `before`x`after` for each coordinate.
void AddNames(const char* before, const char* after, int dimensions, std::vector<std::string>& header) {
  for (int k = 0; k < dimensions; ++k) header.push_back(fmt::format("{}{}{}", before, kCoordinates[k], after));
}

void AddPoint(const Vector3d& point, int dimensions, CsvWriter& csv) {
  for (int k = 0; k < dimensions; ++k) csv.Add(point[k]);
}

Json PointJson(const Vector3d& point, int dimensions) {
  Json json = Json::array();
  for (int k = 0; k < dimensions; ++k) json.push_back(point[k]);
  return json;
}

void WriteAxes(const fs::path& path, const axis::MeanAxesResult& result, const exchange::PointRecording& points,
               int dimensions) {
  std::vector<std::string> header{"window", "first_frame", "last_frame", "flexion_deg"};
  AddNames("", "_mm", dimensions, header);
  if (dimensions == 3) AddNames("n", "", dimensions, header);
  header.emplace_back("sd_mm");
  AddNames("", "_mm_file", dimensions, header);
  if (dimensions == 3) AddNames("n", "_file", dimensions, header);
  CsvWriter csv(header);
  const auto add = [&](const axis::MeanAxis& axis) {
    csv.Add(axis.window).Add(points.frame[axis.first]).Add(points.frame[axis.last]).Add(axis.flexion_deg);
    AddPoint(axis.in_shank, dimensions, csv);
    if (dimensions == 3) AddPoint(axis.direction_shank, dimensions, csv);
    csv.Add(axis.sd_mm);
    AddPoint(axis.in_file, dimensions, csv);
    if (dimensions == 3) AddPoint(axis.direction_file, dimensions, csv);
    csv.EndRow();
  };
  add(result.whole);
  for (const axis::MeanAxis& axis : result.windows) add(axis);
  csv.Write(path);
}

void WriteCentres(const fs::path& path, const std::vector<axis::InstantaneousCentre>& centres,
                  const exchange::PointRecording& points, int dimensions) {
  std::vector<std::string> header{"frame", "time_s", "knee_deg"};
  AddNames("", "_mm", dimensions, header);
  AddNames("sd_", "_mm", dimensions, header);
  AddNames("", "_mm_file", dimensions, header);
  CsvWriter csv(header);
  for (const axis::InstantaneousCentre& centre : centres) {
    csv.Add(points.frame[centre.frame]).Add(points.time_s[centre.frame]).Add(centre.knee_deg);
    AddPoint(centre.in_shank, dimensions, csv);
    AddPoint(centre.sd_mm, dimensions, csv);
    AddPoint(centre.in_file, dimensions, csv);
    csv.EndRow();
  }
  csv.Write(path);
}

// What the clusters do together on the skin, beside what they do against each other.
void AddSoftTissue(double soft_tissue_mm, axis::MeanAxesResult& axes, std::vector<axis::InstantaneousCentre>& centres) {
  axes.whole.sd_mm = std::hypot(axes.whole.sd_mm, soft_tissue_mm);
  for (axis::MeanAxis& axis : axes.windows) axis.sd_mm = std::hypot(axis.sd_mm, soft_tissue_mm);
  const Vector3d& along = axes.whole.direction_shank;
  for (axis::InstantaneousCentre& centre : centres)
    for (int k = 0; k < 3; ++k)
      centre.sd_mm[k] = std::hypot(centre.sd_mm[k], soft_tissue_mm * std::sqrt(1 - along[k] * along[k]));
}

Json PinJson(const axis::MeanAxis& pin, const std::array<double, 2>& range_deg, int dimensions) {
  return {{"from_deg", range_deg[0]},
          {"to_deg", range_deg[1]},
          {"point_mm", PointJson(pin.in_shank, dimensions)},
          {"sd_mm", pin.sd_mm},
          {"residual_mm", pin.pin_residual_mm}};
}

std::string ReportOf(const axis::MeanAxis& whole, int dimensions) {
  const double* const at_mm = whole.in_shank.data();
  return fmt::format(
      "axis over {:.0f}° of flexion: at ({:.1f}) mm from the mean of the shank's markers, standard deviation "
      "{:.2f} mm; a pin there leaves {:.2f} mm\n",
      whole.flexion_deg, fmt::join(at_mm, at_mm + dimensions, ", "), whole.sd_mm, whole.pin_residual_mm);
}

}  // namespace

void Describe(AxisRunOptions& o, OptionList& options) {
  options.AddOperand("trial", o.trial, "A lake-track folder, or .csv (lake, Kinovea), .trc, .c3d, .trk, .txt (Tracker)")
      .Required();
  DescribeSegments("segment", o.segments,
                   "Markers of the shank, and of the thigh: two or more of each, of a 3-D file three or more", options)
      .Required();
  exchange::DescribeUnit("unit", o.mm_per_unit, options);
  exchange::DescribeRate(o.rate_hz, options);
  options.Add("window", o.window_s, "Also the axes of windows of this length, one after the other")
      .Unit("s")
      .AtLeast(0)
      .Otherwise("none");
  options.Add("least-turn", o.least_turn_deg, "How far the segments must turn, also within a window")
      .Unit("degrees")
      .Positive();
  options
      .Add("soft-tissue", o.soft_tissue_mm,
           "Standard deviation, per axis, of the joint against clusters on skin that move as one; 7 for a leg")
      .Unit("mm")
      .Between(kPlausibleMarkerDeviation.low, kPlausibleMarkerDeviation.high);
  options.Add("range", o.range_deg, "Also the best pin between these two knee angles").Value("FROM,TO").Unit("degrees");
  options.Check([&o](const OptionList&) {
    if (o.segments.shank.empty() || o.segments.thigh.empty())
      throw UsageError("--segment: no marker of the {} is given: add --segment {}=MARKER,MARKER",
                       o.segments.shank.empty() ? "shank" : "thigh", o.segments.shank.empty() ? "shank" : "thigh");
  });
}

std::vector<InputFile> InputsOf(const AxisRunOptions& options) {
  return TrialInputs(options.trial, "trial");
}

Json RunAxis(const AxisRunOptions& options, Run& run) {
  const exchange::PointRecording points = ReadMarkers(options);
  run.AddInputs(InputsOf(options));
  const int dimensions = points.space == exchange::PointSpace::kSpace ? 3 : 2;
  const axis::SegmentMotion motion = axis::MotionOf(points, options.segments);
  axis::MeanAxesResult result = axis::MeanAxes(motion, WindowFrames(options, points), options.least_turn_deg);
  std::vector<axis::InstantaneousCentre> centres = axis::InstantaneousCentres(motion, result);
  Json pin;
  if (options.range_deg) {
    axis::MeanAxis best = axis::PinOver(motion, result, (*options.range_deg)[0], (*options.range_deg)[1]);
    best.sd_mm = std::hypot(best.sd_mm, options.soft_tissue_mm);
    pin = PinJson(best, *options.range_deg, dimensions);
  }
  AddSoftTissue(options.soft_tissue_mm, result, centres);
  run.Begin({"summary.json", "axis.csv", "centre.csv", "axis.png", "axis.svg"});
  for (const std::string& warning : points.warnings) run.Warn(warning);
  for (const std::string& warning : result.warnings) run.Warn(warning);
  WriteAxes(run.Result("axis.csv"), result, points, dimensions);
  WriteCentres(run.Result("centre.csv"), centres, points, dimensions);
  DrawPngAndSvg("axis", run, figure::DrawAxis, motion, result, centres);
  const axis::MeanAxis& whole = result.whole;
  run.Report(ReportOf(whole, dimensions));
  return {{"axis_point_mm", PointJson(whole.in_shank, dimensions)},
          {"axis_direction", PointJson(whole.direction_shank, 3)},
          {"axis_sd_mm", whole.sd_mm},
          {"axis_point_mm_file", PointJson(whole.in_file, dimensions)},
          {"axis_direction_file", PointJson(whole.direction_file, 3)},
          {"pin_residual_mm", whole.pin_residual_mm},
          {"flexion_deg", whole.flexion_deg},
          {"shank_marker_sd_mm", motion.shank.marker_sd_mm},
          {"thigh_marker_sd_mm", motion.thigh.marker_sd_mm},
          {"pin_over_range", pin},
          {"windows", result.windows.size()}};
}

}  // namespace lake::commands
