#include "step_costs.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "lake/core/error.h"
#include "lake/video/video_files.h"

namespace lake::study {
namespace {

using steps::StepCost;

// Frames, and a million pixels of each.
struct RecordingSize {
  double frames = 0, megapixels = 0;
};

constexpr double kUsualFrames = 500;  // where a recording does not say

// Of what will be read of it. A file that cannot be opened costs nothing: its step says why.
RecordingSize SizeOf(const std::filesystem::path& video, const video::VideoReaderOptions& options) {
  constexpr double kUsual_hz = 30;
  try {
    const video::FilmSize film = video::SizeOfFilm(video);
    const double rate_hz = options.capture_rate_hz > 0 ? options.capture_rate_hz
                           : film.frame_rate_hz > 0    ? film.frame_rate_hz
                                                       : kUsual_hz;
    double frames = film.frames ? static_cast<double>(*film.frames) : kUsualFrames;
    const double end_s = options.end_s.value_or(frames / rate_hz);
    frames = std::min(frames, std::max(0.0, end_s - options.start_s.value_or(0)) * rate_hz);
    return {frames, 1e-6 * film.width * film.height};
  } catch (const Error&) {
    return {};
  }
}

// A table's frames, one in a row; what is no text has as many as is usual.
double RowsOf(const std::filesystem::path& table) {
  std::ifstream file(table, std::ios::binary);
  if (!file || !std::filesystem::is_regular_file(table) || table.extension() == ".c3d") return kUsualFrames;
  using Characters = std::istreambuf_iterator<char>;
  return static_cast<double>(std::count(Characters(file), Characters(), '\n'));
}

}  // namespace

StepCost CostOf(const commands::CalibrateRunOptions& options) {
  double megapixels = 0;
  for (const std::filesystem::path& picture : options.pictures) {
    const RecordingSize size = SizeOf(picture, {});
    megapixels += std::max(size.frames, 1.0) * size.megapixels;
  }
  return {.seconds = 1 + 0.05 * megapixels, .memory_mb = 300};
}

StepCost CostOf(const commands::PlaneRunOptions&) {
  return {.seconds = 0.8, .memory_mb = 120};
}

StepCost CostOf(const commands::TrackRunOptions& options) {
  const RecordingSize film = SizeOf(options.video, options.track.reader);
  // A frame is decoded and searched, and once more drawn and coded for the overlay.
  double per_frame_s = 0.0001 + 0.0012 * film.megapixels;
  if (options.overlay) per_frame_s += 0.0018 + 0.0009 * film.megapixels;
  return {.seconds = 0.4 + per_frame_s * film.frames,
          // Pictures that are on their way from thread to thread, and the encoder's.
          .memory_mb = 80 + 25 * film.megapixels + (options.overlay ? 65 : 0),
          .processors = 1.85};
}

StepCost CostOf(const commands::GaitRunOptions& options) {
  return {.seconds = 0.1 + 0.0007 * RowsOf(options.trial), .memory_mb = 90};
}

StepCost CostOf(const commands::CompareRunOptions&) {
  return {.seconds = 1, .memory_mb = 95};
}

StepCost CostOfLoads(const StudyTrial& trial) {
  const auto* video = std::get_if<commands::TrackRunOptions>(&trial.work);
  const double frames = video ? SizeOf(video->video, video->track.reader).frames : RowsOf(trial.Recording());
  return {.seconds = 0.1 + 0.0014 * frames, .memory_mb = 75};
}

StepCost CostOf(const commands::OptimizeRunOptions& options) {
  // With an actuator the time of each pose is sought too; of a catalogue, one problem for each row but the first.
  double per_start_s = 0.009;
  if (options.problem.actuator) per_start_s = 0.06;
  if (!options.actuators.empty()) per_start_s = 0.06 * (RowsOf(options.actuators) - 1);
  double seconds = 1 + per_start_s * options.study.optimize.starts;
  if (options.study.certify_gap_deg) seconds += 0.5;
  if (options.reoptimize) seconds += 3 + 0.9 * options.reoptimize->pareto_points.value_or(0);
  return {.seconds = seconds, .memory_mb = 95};
}

StepCost CostOf(const commands::SimulationOptions& options) {
  return {.seconds = options.animation ? 4.8 : 1.5, .memory_mb = 350};
}

StepCost CostOf(const commands::StrokeRunOptions&) {
  return {.seconds = 0.3, .memory_mb = 75};
}

}  // namespace lake::study
