#include <algorithm>

#include "lake/core/error.h"
#include "lake/core/run.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/formats.h"
#include "readers.h"

namespace lake::exchange {
namespace {

namespace fs = std::filesystem;

constexpr double kSameFrame = 0.1, kLeastStep = 0.5;  // in frames

double FrameInterval(const std::vector<PointRecording>& files) {
  std::vector<double> steps_s;
  for (const PointRecording& file : files)
    for (std::size_t i = 1; i < file.time_s.size(); ++i) steps_s.push_back(file.time_s[i] - file.time_s[i - 1]);
  return steps_s.empty() ? 0 : Median(std::move(steps_s));
}

// The times of all files, those of one frame once. Throws Error, naming the `whole`, for times between those of
// another.
std::vector<double> MergeTimes(const std::vector<PointRecording>& files, double interval_s, const fs::path& whole) {
  std::vector<double> all, merged;
  for (const PointRecording& file : files) all.insert(all.end(), file.time_s.begin(), file.time_s.end());
  std::ranges::sort(all);
  for (const double time_s : all) {
    const double step_s = merged.empty() ? interval_s : time_s - merged.back();
    if (!merged.empty() && step_s <= kSameFrame * interval_s) continue;
    if (step_s < kLeastStep * interval_s)
      throw Fail("{}: the files' times do not agree: one has {} s, another {} s, {} of a frame apart", whole.string(),
                 merged.back(), time_s, SignificantText(step_s / interval_s, 3));
    merged.push_back(time_s);
  }
  return merged;
}

PointRecording ReadOne(const fs::path& path, const ReadOptions& options) {
  PointRecording file = ReadPoints(path, options);
  if (file.points.size() != 1)
    throw Fail("{}: {} markers, not one; a folder without lake-track's tables must hold one file per marker",
               path.string(), file.points.size());
  file.points.front().name = path.stem().string();
  return file;
}

PointTrack AtTimes(const std::vector<double>& time_s, const PointRecording& file, double interval_s) {
  PointTrack track{file.points.front().name, std::vector(time_s.size(), PointTrack::Missing())};
  for (std::size_t i = 0; i < file.time_s.size(); ++i) {
    const auto after = std::upper_bound(time_s.begin(), time_s.end(), file.time_s[i]);
    const auto frame = static_cast<std::size_t>(after - time_s.begin()) - 1;
    if (file.time_s[i] - time_s[frame] <= kSameFrame * interval_s)
      track.positions[frame] = file.points.front().positions[i];
  }
  return track;
}

}  // namespace

std::vector<fs::path> MarkerFilesOf(const fs::path& path) {
  std::vector<fs::path> files;
  if (!fs::is_directory(path) || FindResult(path, "tracks.csv") || FindResult(path, "trajectory.csv") ||
      fs::exists(path / "summary.json"))
    return files;
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    const std::string ending = Lower(entry.path().extension().string());
    if (entry.is_regular_file() && (ending == ".txt" || ending == ".csv")) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

PointRecording ReadMarkerFiles(const std::vector<fs::path>& paths, const ReadOptions& options) {
  std::vector<PointRecording> files;
  files.reserve(paths.size());
  for (const fs::path& path : paths) files.push_back(ReadOne(path, options));
  for (std::size_t k = 0; k < files.size(); ++k)
    if (files[k].space != files.front().space || files[k].mm_per_px != files.front().mm_per_px)
      throw Fail("{}: another kind of positions, or another scale, than {}", paths[k].string(), paths.front().string());
  return JoinMarkers(files, paths.front().parent_path());
}

PointRecording JoinMarkers(const std::vector<PointRecording>& files, const fs::path& whole) {
  const double interval_s = FrameInterval(files);
  PointRecording merged = files.front();
  merged.points.clear();
  merged.time_s = MergeTimes(files, interval_s, whole);
  merged.frame.resize(merged.time_s.size());
  for (std::size_t i = 0; i < merged.frame.size(); ++i) merged.frame[i] = static_cast<std::int64_t>(i);
  for (std::size_t k = 0; k < files.size(); ++k) {
    merged.points.push_back(AtTimes(merged.time_s, files[k], interval_s));
    if (k > 0) std::ranges::copy(files[k].warnings, std::back_inserter(merged.warnings));
  }
  return merged;
}

}  // namespace lake::exchange
