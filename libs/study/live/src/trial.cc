#include "trial.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/child_program.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"

namespace lake::live {

namespace fs = std::filesystem;

std::vector<std::string> TrackArguments(const LiveRunOptions& options, const std::vector<std::string>& more) {
  std::vector<std::string> words = {fmt::format("--markers={}", fmt::join(options.markers, ","))};
  if (options.camera) words.push_back("--camera=" + fs::absolute(*options.camera).string());
  for (const auto& [marker, depth] : options.depths)
    words.push_back(fmt::format("--depth={}={}", marker, OptionValue<gait::MarkerDepth>::Format(depth)));
  for (const auto& [segment, names] : options.fit.technical)
    words.push_back(fmt::format("--technical={}={}", segment, fmt::join(names, ",")));
  if (options.fit.knee_trial) words.push_back("--knee-from=" + fs::absolute(*options.fit.knee_trial).string());
  if (options.scale) words.push_back(fmt::format("--scale={}", fmt::join(*options.scale, ",")));
  if (!options.plane_points.empty()) words.push_back("--plane-points=" + options.plane_points);
  if (options.polarity == tracking::Polarity::kDark) words.push_back("--polarity=dark");
  if (!options.crop.empty())
    words.push_back(
        fmt::format("--crop={},{},{},{}", options.crop.x, options.crop.y, options.crop.width, options.crop.height));
  if (options.stream.rotate_deg != 0) words.push_back(fmt::format("--rotate={}", options.stream.rotate_deg));
  if (!options.overlay) words.push_back("--no-overlay");
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

void TrackTrial(const fs::path& programs, const fs::path& folder, const std::vector<std::string>& arguments,
                const std::function<void(const std::string& line)>& say, const std::function<void()>& check) {
  std::vector<std::string> words = {(folder / kVideo).string(), "-o", folder.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const ChildEnd end = RunChild(programs / "lake-track", words, say, check);
  if (end.code != 0)
    throw Fail("{}: the recording is whole, but lake track makes no trial of it: {}", (folder / kVideo).string(),
               end.last_line);
}

std::optional<double> Distances::RmsPx() const {
  if (count == 0) return std::nullopt;
  return std::sqrt(squares / static_cast<double>(count));
}

std::optional<double> Distances::LargestPx() const {
  if (count == 0) return std::nullopt;
  return largest_px;
}

LiveDifference FindDifference(const motion::MarkerRecording& recorded, const fs::path& folder) {
  const motion::MarkerRecording offline = motion::ReadMarkerCsv(folder / "tracks.csv");
  // Where a recording was cut, a picture that others are coded from may be missing before its last ones: what has the
  // same number is then not the same picture. Matroska's times are rounded to a millisecond.
  constexpr double kRounding_s = 0.002;
  std::optional<double> first_apart_s;
  LiveDifference difference;
  difference.markers.reserve(recorded.markers.size());
  for (const motion::MarkerTrack& live : recorded.markers) {
    const motion::MarkerTrack* track = offline.Find(live.name);
    Distances own;
    for (std::size_t row = 0; track && row < offline.Frames(); ++row) {
      const auto found = std::ranges::lower_bound(recorded.frame, offline.frame[row]);
      if (found == recorded.frame.end() || *found != offline.frame[row]) continue;
      const double apart_s =
          recorded.time_s[static_cast<std::size_t>(found - recorded.frame.begin())] - offline.time_s[row];
      if (!first_apart_s) first_apart_s = apart_s;
      if (std::abs(apart_s - *first_apart_s) > kRounding_s) continue;
      const motion::MarkerSample& then = live.samples[static_cast<std::size_t>(found - recorded.frame.begin())];
      if (then.status != motion::SampleStatus::kDetected ||
          track->samples[row].status != motion::SampleStatus::kDetected)
        continue;
      const double away_px = (then.position - track->samples[row].position).norm();
      own.squares += away_px * away_px;
      own.largest_px = std::max(own.largest_px, away_px);
      ++own.count;
    }
    difference.all.squares += own.squares;
    difference.all.largest_px = std::max(difference.all.largest_px, own.largest_px);
    difference.all.count += own.count;
    difference.markers.emplace_back(live.name, own);
  }
  return difference;
}

Json DifferenceJson(const LiveDifference& difference) {
  Json markers = Json::object();
  for (const auto& [name, own] : difference.markers)
    markers[name] = {
        {"frames", own.count}, {"rms_px", NumberOrNull(own.RmsPx())}, {"largest_px", NumberOrNull(own.LargestPx())}};
  return {{"rms_px", NumberOrNull(difference.all.RmsPx())},
          {"largest_px", NumberOrNull(difference.all.LargestPx())},
          {"markers", markers}};
}

}  // namespace lake::live
