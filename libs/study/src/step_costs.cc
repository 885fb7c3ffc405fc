#include "step_costs.h"

#include <algorithm>

#include "lake/core/error.h"
#include "lake/video/video_reader.h"

namespace lake::study {
namespace {

using steps::StepCost;

// Frames, and a million pixels of each.
struct FilmSize {
  double frames = 0, megapixels = 0;
};

// Of what will be read of it. A file that cannot be opened costs nothing: its step says why.
FilmSize SizeOf(const std::filesystem::path& video, const video::VideoReaderOptions& options) {
  try {
    const video::VideoInfo info = video::VideoReader::Open(video, options)->Info();
    constexpr double kUsualFrames = 500;  // where the container does not say
    double frames = info.frames ? static_cast<double>(*info.frames) : kUsualFrames;
    const double end_s = options.end_s.value_or(frames / std::max(info.frame_rate_hz, 1.0));
    frames = std::min(frames, std::max(0.0, end_s - options.start_s.value_or(0)) * info.frame_rate_hz);
    return {frames, 1e-6 * info.width * info.height};
  } catch (const Error&) {
    return {};
  }
}

}  // namespace

StepCost CostOf(const commands::CalibrateRunOptions& options) {
  double megapixels = 0;
  for (const std::filesystem::path& picture : options.pictures) {
    const FilmSize size = SizeOf(picture, {});
    megapixels += std::max(size.frames, 1.0) * size.megapixels;
  }
  return {.seconds = 1 + 0.05 * megapixels, .memory_mb = 300};
}

StepCost CostOf(const commands::PlaneRunOptions&) {
  return {.seconds = 0.8, .memory_mb = 120};
}

StepCost CostOf(const commands::TrackRunOptions& options) {
  const FilmSize film = SizeOf(options.video, options.track.reader);
  // A frame is decoded and searched twice, and once more drawn and coded for the overlay; the fit and the figures take
  // their time by frames alone.
  const double per_megapixel_s = options.overlay ? 0.005 : 0.002;
  return {.seconds = 1.5 + film.frames * (0.0022 + per_megapixel_s * film.megapixels),
          .memory_mb = 150 + 130 * film.megapixels};
}

StepCost CostOf(const commands::GaitRunOptions&) {
  return {.seconds = 1, .memory_mb = 100};
}

StepCost CostOf(const commands::CompareRunOptions&) {
  return {.seconds = 1, .memory_mb = 85};
}

StepCost CostOf(const commands::LoadsRunOptions&) {
  return {.seconds = 1.2, .memory_mb = 80};
}

StepCost CostOf(const commands::OptimizeRunOptions& options) {
  double seconds = 1 + 0.06 * options.study.optimize.starts;
  if (options.study.certify_gap_deg) seconds += 0.5;
  if (options.reoptimize) seconds += 3 + 0.9 * options.reoptimize->pareto_points.value_or(0);
  return {.seconds = seconds, .memory_mb = 85};
}

StepCost CostOf(const commands::SimulationOptions& options) {
  return {.seconds = options.animation ? 5.0 : 1.5, .memory_mb = 480};
}

StepCost CostOf(const commands::StrokeRunOptions&) {
  return {.seconds = 0.3, .memory_mb = 60};
}

}  // namespace lake::study
