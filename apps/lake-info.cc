// lake-info: what is inside a trial file.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/provenance.h"
#include "lake/exchange/mot.h"
#include "lake/exchange/trial.h"

namespace {

int Complain(const std::string& text, int code) {
  fmt::print(stderr, "lake-info: {}\n", text);
  return code;
}

lake::Json Timing(const std::vector<double>& time_s) {
  if (time_s.empty()) return {{"frames", 0}};
  double shortest = INFINITY, longest = 0;
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    shortest = std::min(shortest, time_s[i] - time_s[i - 1]);
    longest = std::max(longest, time_s[i] - time_s[i - 1]);
  }
  return {{"frames", time_s.size()},     {"first_s", time_s.front()},
          {"last_s", time_s.back()},     {"rate_hz", lake::FrameRate(time_s)},
          {"shortest_step_s", shortest}, {"longest_step_s", longest}};
}

lake::Json DescribePoints(const lake::PointRecording& points) {
  lake::Json info = Timing(points.time_s), markers = lake::Json::array();
  const char* kSpaces[] = {"image, px", "plane, mm", "space, mm"};
  info["coordinates"] = kSpaces[static_cast<int>(points.space)];
  if (points.space == lake::PointSpace::kSpace) info["up"] = std::string(1, points.up_axis);
  if (points.mm_per_px) info["mm_per_px"] = *points.mm_per_px;
  for (const lake::PointTrack& point : points.points) {
    const auto seen =
        std::count_if(point.positions.begin(), point.positions.end(), [](const auto& p) { return p.allFinite(); });
    markers.push_back({{"name", point.name}, {"seen", seen}});
  }
  info["markers"] = markers;
  return info;
}

lake::Json Describe(const std::filesystem::path& path, double mm_per_unit) {
  if (path.extension() != ".mot" && path.extension() != ".sto")
    return DescribePoints(lake::ReadPoints(path, mm_per_unit));
  const lake::MotTable table = lake::ReadMot(path);
  lake::Json info = Timing(table.time_s);
  info["in_degrees"] = table.in_degrees;
  info["columns"] = table.columns;
  return info;
}

void Print(const lake::Json& info) {
  for (const auto& [key, value] : info.items()) {
    if (key != "markers" && key != "columns") {
      fmt::print("{:<16} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
      continue;
    }
    fmt::print("{:<16} {}\n", key, value.size());
    for (const lake::Json& item : value)
      item.is_string()
          ? fmt::print("  {}\n", item.get<std::string>())
          : fmt::print("  {:<24} seen in {} frames\n", item["name"].get<std::string>(), item["seen"].dump());
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App cli("What is inside a trial file: frames, rate, markers", "lake-info");
  cli.footer("Example:\n  lake-info walking.c3d");
  std::string file;
  double mm_per_unit = 1;
  bool json = false;
  cli.add_option("file", file, "A lake-track folder, or .trc, .c3d, .trk, .txt, .csv, .mot, .sto")->required();
  cli.add_option("--mm-per-unit", mm_per_unit, "Of files that do not say their unit (Tracker text, Kinovea)")
      ->capture_default_str();
  cli.add_flag("--json", json, "As JSON");
  cli.set_version_flag("--version", fmt::format("lake-info {}", lake::Version()));
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return error.get_exit_code() == 0 ? cli.exit(error)
                                      : Complain(std::string(error.what()) + "; see lake-info --help", 2);
  }
  try {
    const lake::Json info = Describe(file, mm_per_unit);
    json ? fmt::print("{}\n", info.dump(2)) : Print(info);
    return 0;
  } catch (const std::exception& error) {
    return Complain(error.what(), 1);
  }
}
