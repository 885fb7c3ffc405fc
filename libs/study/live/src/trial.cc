#include "trial.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/child_program.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::live {

namespace fs = std::filesystem;

std::vector<std::string> TrackArguments(const LiveRunOptions& options, const std::vector<std::string>& more) {
  std::vector<std::string> words = {fmt::format("--markers={}", fmt::join(options.markers, ","))};
  if (options.camera) words.push_back("--camera=" + fs::absolute(*options.camera).string());
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

Json DifferenceJson(const motion::MarkerRecording& told, const fs::path& folder) {
  const motion::MarkerRecording offline = motion::ReadMarkerCsv(folder / "tracks.csv");
  // Where a recording was cut, a picture that others are coded from may be missing before its last ones: what has the
  // same number is then not the same picture. Matroska's times are rounded to a millisecond.
  constexpr double kRounding_s = 0.002;
  std::optional<double> first_apart_s;
  double squares = 0, largest = 0;
  std::int64_t count = 0;
  Json markers = Json::object();
  for (const motion::MarkerTrack& live : told.markers) {
    const motion::MarkerTrack* track = offline.Find(live.name);
    double own_squares = 0, own_largest = 0;
    std::int64_t own_count = 0;
    for (std::size_t row = 0; track && row < offline.Frames(); ++row) {
      const auto found = std::ranges::lower_bound(told.frame, offline.frame[row]);
      if (found == told.frame.end() || *found != offline.frame[row]) continue;
      const double apart_s = told.time_s[static_cast<std::size_t>(found - told.frame.begin())] - offline.time_s[row];
      if (!first_apart_s) first_apart_s = apart_s;
      if (std::abs(apart_s - *first_apart_s) > kRounding_s) continue;
      const motion::MarkerSample& then = live.samples[static_cast<std::size_t>(found - told.frame.begin())];
      if (then.status != motion::SampleStatus::kDetected ||
          track->samples[row].status != motion::SampleStatus::kDetected)
        continue;
      const double away = (then.position - track->samples[row].position).norm();
      own_squares += away * away;
      own_largest = std::max(own_largest, away);
      ++own_count;
    }
    const bool has_any = own_count > 0;
    markers[live.name] = {{"frames", own_count},
                          {"rms_px", has_any ? Json(std::sqrt(own_squares / static_cast<double>(own_count))) : Json()},
                          {"largest_px", has_any ? Json(own_largest) : Json()}};
    squares += own_squares;
    largest = std::max(largest, own_largest);
    count += own_count;
  }
  return {{"rms_px", count > 0 ? Json(std::sqrt(squares / static_cast<double>(count))) : Json()},
          {"largest_px", count > 0 ? Json(largest) : Json()},
          {"markers", markers}};
}

}  // namespace lake::live
