#include "step_costs.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "lake/core/error.h"
#include "lake/core/threads.h"
#include "lake/video/video_files.h"

namespace lake::study {
namespace {

using steps::StepCost;

// What a piece of work takes, measured (tests/benchmark/plan_cost.py): whatever its size, for each frame (each start,
// where designs are sought), and for each million pixels of a frame.
struct Rates {
  double fixed_s = 0, frame_s = 0, megapixel_s = 0;
  double fixed_mb = 0, megapixel_mb = 0;
  double processors = 1;  // that it keeps busy
};

constexpr Rates kCalibrate{.fixed_s = 1, .megapixel_s = 0.05, .fixed_mb = 300};
constexpr Rates kPlane{.fixed_s = 0.8, .fixed_mb = 120};
// A frame is decoded and searched; for the overlay decoded, drawn and coded. Pictures on their way from thread to
// thread, and the encoder's, take the memory.
constexpr Rates kTrack{
    .fixed_s = 0.4, .frame_s = 0.0003, .megapixel_s = 0.0012, .fixed_mb = 135, .megapixel_mb = 50, .processors = 1.85};
constexpr Rates kTrackWithOverlay{
    .fixed_s = 0.4, .frame_s = 0.0021, .megapixel_s = 0.0021, .fixed_mb = 225, .megapixel_mb = 50, .processors = 1.85};
constexpr Rates kGait{.fixed_s = 0.1, .frame_s = 0.0007, .fixed_mb = 90};
constexpr Rates kCompare{.fixed_s = 1, .fixed_mb = 130};
constexpr Rates kLoads{.fixed_s = 0.1, .frame_s = 0.0014, .fixed_mb = 105};
constexpr Rates kOptimize{.fixed_s = 1, .frame_s = 0.018, .fixed_mb = 115};
constexpr Rates kOptimizeWithActuator{.fixed_s = 1, .frame_s = 0.06, .fixed_mb = 115};
constexpr double kCertify_s = 0.5;
constexpr double kReoptimize_s = 3, kParetoPoint_s = 1.6;  // of processor time
constexpr Rates kFigures{.fixed_s = 0.7, .fixed_mb = 95};
constexpr Rates kFiguresAndAnimation{.fixed_s = 4.3, .fixed_mb = 385, .processors = 1.4};
constexpr Rates kStroke{.fixed_s = 0.1, .fixed_mb = 95};

// Frames, and a million pixels of each.
struct RecordingSize {
  double frames = 0, megapixels = 0;
};

StepCost CostAt(const Rates& rates, const RecordingSize& size = {}) {
  return {.seconds = rates.fixed_s + size.frames * (rates.frame_s + rates.megapixel_s * size.megapixels),
          .memory_mb = rates.fixed_mb + rates.megapixel_mb * size.megapixels,
          .processors = rates.processors};
}

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

// A table's lines, of which a recording has one for each frame; as many as is usual of what is no text or cannot be
// read twice, as a pipe.
double RowsOf(const std::filesystem::path& table) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(table, ignored) || table.extension() == ".c3d") return kUsualFrames;
  std::ifstream file(table, std::ios::binary);
  using Characters = std::istreambuf_iterator<char>;
  return static_cast<double>(std::count(Characters(file), Characters(), '\n'));
}

// Points that are computed as many at a time as there are threads, once the rest is done.
void AddParetoPoints(int points, StepCost& cost) {
  const int rounds = (points + Threads() - 1) / Threads();
  const double busy_s = cost.processors * cost.seconds + kParetoPoint_s * points;
  cost.seconds += kParetoPoint_s * rounds;
  cost.processors = busy_s / cost.seconds;
}

}  // namespace

StepCost CostOf(const commands::CalibrateRunOptions& options) {
  double megapixels = 0;
  for (const std::filesystem::path& picture : options.pictures) {
    const RecordingSize size = SizeOf(picture, {});
    megapixels += std::max(size.frames, 1.0) * size.megapixels;
  }
  return CostAt(kCalibrate, {.frames = 1, .megapixels = megapixels});
}

StepCost CostOf(const commands::PlaneRunOptions&) {
  return CostAt(kPlane);
}

StepCost CostOf(const commands::TrackRunOptions& options) {
  return CostAt(options.overlay ? kTrackWithOverlay : kTrack, SizeOf(options.video, options.track.reader));
}

StepCost CostOf(const commands::GaitRunOptions& options) {
  return CostAt(kGait, {.frames = RowsOf(options.trial)});
}

StepCost CostOf(const commands::CompareRunOptions&) {
  return CostAt(kCompare);
}

StepCost CostOfLoads(const StudyTrial& trial) {
  const auto* video = std::get_if<commands::TrackRunOptions>(&trial.work);
  return CostAt(kLoads,
                {.frames = video ? SizeOf(video->video, video->track.reader).frames : RowsOf(trial.Recording())});
}

StepCost CostOf(const commands::OptimizeRunOptions& options) {
  // Of a catalogue, one problem for each row but the first. Why one cannot be read is said by the step.
  std::error_code ignored;
  const bool has_catalogue = std::filesystem::is_regular_file(options.actuators, ignored);
  const double problems = has_catalogue ? std::max(0.0, RowsOf(options.actuators) - 1) : 1;
  const bool with_actuator = options.problem.actuator || !options.actuators.empty();
  StepCost cost =
      CostAt(with_actuator ? kOptimizeWithActuator : kOptimize, {.frames = problems * options.study.optimize.starts});
  if (options.study.certify_gap_deg) cost.seconds += kCertify_s;
  if (!options.reoptimize) return cost;
  cost.seconds += kReoptimize_s;
  AddParetoPoints(options.reoptimize->pareto_points.value_or(0), cost);
  return cost;
}

StepCost CostOf(const commands::SimulationOptions& options) {
  return CostAt(options.animation ? kFiguresAndAnimation : kFigures);
}

StepCost CostOf(const commands::StrokeRunOptions&) {
  return CostAt(kStroke);
}

}  // namespace lake::study
