// lake-info: what is inside a trial file.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lake/camera/camera.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/convert.h"
#include "lake/exchange/mot.h"
#include "program.h"

namespace {

lake::Json Timing(const std::vector<double>& time_s) {
  if (time_s.size() < 2) return {{"frames", time_s.size()}};
  double shortest = INFINITY, longest = 0;
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    shortest = std::min(shortest, time_s[i] - time_s[i - 1]);
    longest = std::max(longest, time_s[i] - time_s[i - 1]);
  }
  return {{"frames", time_s.size()},     {"first_s", time_s.front()},
          {"last_s", time_s.back()},     {"rate_hz", lake::exchange::FrameRate(time_s)},
          {"shortest_step_s", shortest}, {"longest_step_s", longest}};
}

// Seen in how many frames; runs of frames without it, and the longest of them.
lake::Json DescribePoint(const lake::exchange::PointTrack& point) {
  std::size_t seen = 0, gaps = 0, gap = 0, longest = 0;
  for (const auto& position : point.positions) {
    const bool missing = !position.allFinite();
    seen += missing ? 0 : 1;
    gap = missing ? gap + 1 : 0;
    gaps += gap == 1 ? 1 : 0;
    longest = std::max(longest, gap);
  }
  return {{"name", point.name}, {"seen", seen}, {"gaps", gaps}, {"longest_gap_frames", longest}};
}

lake::Json DescribePoints(const lake::exchange::PointRecording& points) {
  lake::Json info = Timing(points.time_s), markers = lake::Json::array();
  const char* kSpaces[] = {"image, px", "plane, mm", "space, mm"};
  info["coordinates"] = kSpaces[static_cast<int>(points.space)];
  if (points.space == lake::exchange::PointSpace::kSpace) info["up"] = std::string(1, points.up_axis);
  if (points.mm_per_px) info["mm_per_px"] = *points.mm_per_px;
  for (const lake::exchange::PointTrack& point : points.points) markers.push_back(DescribePoint(point));
  info["markers"] = markers;
  lake::Json events = lake::Json::array();
  for (const lake::exchange::PointEvent& event : points.events)
    events.push_back({{"time_s", event.time_s}, {"context", event.context}, {"label", event.label}});
  if (!events.empty()) info["events"] = events;
  lake::Json outputs = lake::Json::array();
  for (const lake::exchange::ModelOutput& output : points.outputs)
    outputs.push_back({{"name", output.name}, {"kind", output.kind}, {"unit", output.unit}});
  if (!outputs.empty()) info["model_outputs"] = outputs;
  info["warnings"] = points.warnings;
  return info;
}

lake::Json DescribeCamera(const lake::camera::CameraProfile& profile) {
  const lake::camera::Camera& camera = profile.camera;
  std::vector<double> coefficients(camera.distortion.begin(), camera.distortion.end());
  if (!camera.IsPlain()) coefficients.insert(coefficients.end(), camera.more.begin(), camera.more.end());
  const bool is_fisheye = camera.model == lake::camera::LensModel::kFisheye;
  if (is_fisheye) coefficients.resize(4);
  return {{"picture_px", fmt::format("{} x {}", camera.image_width, camera.image_height)},
          {"fx_px", camera.fx},
          {"fy_px", camera.fy},
          {"cx_px", camera.cx},
          {"cy_px", camera.cy},
          {"lens", is_fisheye ? "fisheye" : "polynomial"},
          {"coefficients", fmt::format("{:g}", fmt::join(coefficients, " "))},
          {"sagittal_plane", profile.camera_from_plane ? "calibrated" : "none"},
          {"warnings", profile.warnings}};
}

lake::Json Describe(const std::filesystem::path& path, const lake::exchange::TrialOptions& reading) {
  if (lake::camera::IsCameraFile(path)) return DescribeCamera(lake::camera::ReadCameraProfile(path, reading.view));
  if (!lake::exchange::IsMot(path)) {
    lake::exchange::CheckNoneIsUnused(path, lake::exchange::UnusedOptions(path, reading));
    return DescribePoints(lake::exchange::ReadPoints(path, reading.Reading()));
  }
  if (reading.mm_per_unit != 1 || reading.rate_hz > 0)
    throw lake::UsageError("{}: holds angles: --unit and --rate are for points", path.string());
  const lake::exchange::MotTable table = lake::exchange::ReadMot(path);
  lake::Json info = Timing(table.time_s);
  info["in_degrees"] = table.in_degrees;
  info["columns"] = table.columns;
  info["warnings"] = table.warnings;
  return info;
}

void PrintMarkers(const lake::Json& markers) {
  fmt::print("{:<16} {}\n", "markers", markers.size());
  std::size_t width = 12;
  for (const lake::Json& marker : markers) width = std::max(width, marker["name"].get_ref<const std::string&>().size());
  for (const lake::Json& marker : markers) {
    fmt::print("  {:<{}}  seen in {} frames", marker["name"].get<std::string>(), width, marker["seen"].dump());
    if (marker["gaps"] != 0)
      fmt::print(", missing {} times, for {} frames at most", marker["gaps"].dump(),
                 marker["longest_gap_frames"].dump());
    fmt::print("\n");
  }
}

void PrintEvents(const lake::Json& events) {
  fmt::print("{:<16} {}\n", "events", events.size());
  for (const lake::Json& event : events)
    fmt::print("  {:9.4f} s  {} {}\n", event["time_s"].get<double>(), event["context"].get<std::string>(),
               event["label"].get<std::string>());
}

void PrintOutputs(const lake::Json& outputs) {
  fmt::print("{:<16} {}\n", "model outputs", outputs.size());
  for (const lake::Json& output : outputs)
    fmt::print("  {:<16} {} {}\n", output["name"].get<std::string>(), output["kind"].get<std::string>(),
               output["unit"].get<std::string>());
}

std::string Text(const lake::Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_number_float()) return value.dump();
  constexpr double kSixDigits = 1e6;
  const double number = value.get<double>();
  return std::abs(number) < kSixDigits ? lake::SignificantText(number, 6) : fmt::format("{:.0f}", number);
}

void Print(const lake::Json& info) {
  for (const auto& [key, value] : info.items()) {
    if (key == "markers") {
      PrintMarkers(value);
    } else if (key == "events") {
      PrintEvents(value);
    } else if (key == "model_outputs") {
      PrintOutputs(value);
    } else if (value.is_array()) {
      if (value.empty()) continue;
      fmt::print("{:<16} {}\n", key, value.size());
      for (const lake::Json& item : value) fmt::print("  {}\n", item.get<std::string>());
    } else {
      fmt::print("{:<16} {}\n", key, Text(value));
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path file;
  lake::exchange::TrialOptions reading;
  bool json = false;
  lake::OptionList options;
  options
      .AddOperand("file", file,
                  "A lake-track folder, or " + lake::exchange::ReadableEndings() + ", .mot, .sto; or a camera's file")
      .Required();
  lake::exchange::DescribeUnit("unit", reading.mm_per_unit, options);
  lake::exchange::DescribeRate(reading.rate_hz, options);
  lake::exchange::DescribeView(reading.view, options);
  options.Add("json", json, "As JSON");
  return lake::RunTool("lake-info",
                       "What is inside a trial file: frames, rate, unit, markers and their gaps; or a camera's",
                       "Example:\n  lake-info walking.c3d", std::move(options), argc, argv, [&] {
                         const lake::Json info = Describe(file, reading);
                         if (json)
                           fmt::print("{}\n", info.dump(2, ' ', false, lake::Json::error_handler_t::replace));
                         else
                           Print(info);
                       });
}
