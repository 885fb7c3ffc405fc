// A rendered recording, tracked, held against its own truth.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "lake/commands/track.h"
#include "lake/core/csv.h"
#include "lake/core/statistics.h"
#include "lake/motion/marker_recording.h"
#include "lake/synth/recording.h"
#include "temporary_folder.h"

namespace lake {

// CleanScene without the room on both sides of the person: the leg is as large, and a picture has half as many pixels.
inline synth::SceneOptions CleanLeg(std::uint64_t seed) {
  synth::SceneOptions scene = synth::CleanScene(seed);
  scene.width_px = 720;
  return scene;
}

// For what does not ask how large the errors are that the encoder leaves: what x264 does in half the time; and without
// the camera's noise, which is most of what is coded and decoded in finer films.
inline constexpr const char* kQuickEncoder = "ultrafast";
inline const synth::RecordingOptions kQuickly{.crf = 23, .preset = kQuickEncoder};

// A hand that covers 10 to 15 % of a marker makes the truth call it hidden, though most of its rim is to be seen:
// detecting it there is no false detection, but its error does not count either.
inline constexpr double kBorderCovered = 0.15;

// A scene, its recording and a run on it, in a folder that vanishes with it.
struct RenderedTrial {
  RenderedTrial(const synth::SceneOptions& options, const synth::RecordingOptions& recording)
      : RenderedTrial(synth::Scene(options), recording) {}
  RenderedTrial(synth::Scene rendered, const synth::RecordingOptions& recording) : scene(std::move(rendered)) {
    synth::WriteRecording(scene, folder.Path(), recording);
  }

  // Without a video yet: for a test that makes its own in `folder`.
  explicit RenderedTrial(synth::Scene rendered) : scene(std::move(rendered)) {
    camera::WriteCameraProfile(folder / "camera.yaml", scene.Profile());
  }

  // Tracks the video with the recording's own camera, without an overlay, into a folder of this name.
  Json Track(const std::string& name = "trial", const std::function<void(commands::TrackRunOptions&)>& change = {}) {
    commands::TrackRunOptions options;
    options.video = folder / "video.mp4";
    options.camera = folder / "camera.yaml";
    options.overlay = false;
    options.track.quiet = true;
    if (change) change(options);
    Run run({"lake-track", "test", Json::object(), folder / name, true});
    return run.WriteSummary(commands::RunTrack(options, run));
  }

  // Of a frame; made once, as several comparisons ask for it.
  const synth::FrameTruth& Truth(int frame) const {
    const auto known = truth_.find(frame);
    return known != truth_.end() ? known->second : truth_.emplace(frame, scene.Truth(frame)).first->second;
  }

  motion::MarkerRecording Tracks(const std::string& name = "trial") const {
    return motion::ReadMarkerCsv(folder / name / "tracks.csv");
  }

  // The fit's estimates where they lie in the picture, at the frames and with the statuses of the tracks.
  motion::MarkerRecording EstimatesInPicture(const std::string& name = "trial") const {
    motion::MarkerRecording estimates =
        motion::ReadMarkerCsv(folder / name / "trajectory.csv", motion::MarkerValues::kEstimated);
    const gait::LegView view = gait::MakeLegView(motion::LengthUnit::kPx, scene.Profile());
    for (motion::MarkerTrack& marker : estimates.markers)
      for (motion::MarkerSample& sample : marker.samples) {
        if (!sample.IsKnown()) continue;
        sample.sigma /= gait::PlaneUnitsPerRecorded(view, sample.position, 0);
        sample.position = gait::RecordedFromPlane<double>(view, sample.position, 0);
      }
    estimates.unit = motion::LengthUnit::kPx;
    return estimates;
  }

  TemporaryFolder folder;
  synth::Scene scene;

 private:
  mutable std::map<int, synth::FrameTruth> truth_;
};

struct TrackErrors {
  double rms_px = 0;       // 2-D, of what was detected while visible
  double axis_px = 0;      // the same per axis
  double worst_px = 0;     // 2-D
  double recall = 0;       // detected of what is visible
  int false_samples = 0;   // detected though covered by more than kBorderCovered
  int border_samples = 0;  // detected though covered by 10 to 15 %
  double z_deviation = 0;  // of error / sigma
  double filled_px = 0;    // rms 2-D, of what was filled while hidden; 0 without any
  int filled = 0;
};

inline double RootMean(double sum, int count) {
  return count > 0 ? std::sqrt(sum / count) : 0;
}

inline TrackErrors CompareTracks(const motion::MarkerRecording& tracks, const RenderedTrial& trial) {
  TrackErrors errors;
  int visible = 0, detected = 0;
  double square_sum = 0, z_sum = 0, filled_sum = 0;
  for (std::size_t i = 0; i < tracks.Frames(); ++i) {
    const synth::FrameTruth& truth = trial.Truth(static_cast<int>(tracks.frame[i]));
    for (const motion::MarkerTrack& marker : tracks.markers) {
      const synth::MarkerTruth& true_marker =
          truth.markers[static_cast<std::size_t>(synth::IndexOfMarker(trial.scene.Motion(), marker.name))];
      const motion::MarkerSample& sample = marker.samples[i];
      const double error = (sample.position - true_marker.px).norm();
      visible += true_marker.visible;
      if (sample.status == motion::SampleStatus::kDetected && true_marker.visible) {
        ++detected;
        square_sum += error * error;
        z_sum += error * error / (sample.sigma * sample.sigma) / 2;
        errors.worst_px = std::max(errors.worst_px, error);
      } else if (sample.status == motion::SampleStatus::kDetected) {
        ++(true_marker.covered > kBorderCovered ? errors.false_samples : errors.border_samples);
      } else if (sample.status == motion::SampleStatus::kFilled && !true_marker.visible) {
        ++errors.filled;
        filled_sum += error * error;
      }
    }
  }
  errors.rms_px = RootMean(square_sum, detected);
  errors.axis_px = errors.rms_px / std::sqrt(2);
  errors.z_deviation = RootMean(z_sum, detected);
  errors.filled_px = RootMean(filled_sum, errors.filled);
  errors.recall = visible > 0 ? static_cast<double>(detected) / visible : 0;
  return errors;
}

struct KneeErrors {
  double fitted_deg = 0, raw_deg = 0;  // rms
  double seen_deg = 0;                 // rms of fitted where ankle, knee and hip are all visible
  double peak_deg = 0;                 // largest error of largest flexion and extension
  double z_deviation = 0;              // of error / sigma of the fitted angle
  double within_2_sd = 0;              // share of frames
  int frames = 0, raw_frames = 0;
};

inline KneeErrors CompareKnee(const std::filesystem::path& kinematics_csv, const RenderedTrial& trial) {
  const CsvTable table = CsvTable::Read(kinematics_csv);
  const std::size_t frame = table.Column("frame"), fitted = table.Column("knee_deg"),
                    sigma = table.Column("knee_sigma_deg"), raw = table.Column("knee_raw_deg");
  KneeErrors errors;
  double fitted_sum = 0, seen_sum = 0, raw_sum = 0, z_sum = 0;
  double least = INFINITY, most = -INFINITY, true_least = INFINITY, true_most = -INFINITY;
  int within = 0, seen_frames = 0;
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const synth::FrameTruth& frame_truth = trial.Truth(static_cast<int>(table.RequiredNumber(row, frame)));
    const double truth = frame_truth.knee_deg;
    const bool seen =
        std::all_of(tracking::kLegMarkers.begin(), tracking::kLegMarkers.begin() + 3, [&](std::string_view marker) {
          return frame_truth.markers[static_cast<std::size_t>(synth::IndexOfMarker(trial.scene.Motion(), marker))]
              .visible;
        });
    true_least = std::min(true_least, truth);
    true_most = std::max(true_most, truth);
    if (const auto angle = table.Number(row, fitted)) {
      const double z = (*angle - truth) / table.RequiredNumber(row, sigma);
      fitted_sum += std::pow(*angle - truth, 2), z_sum += z * z, within += std::abs(z) <= 2, ++errors.frames;
      if (seen) seen_sum += std::pow(*angle - truth, 2), ++seen_frames;
      least = std::min(least, *angle);
      most = std::max(most, *angle);
    }
    if (const auto angle = table.Number(row, raw)) raw_sum += std::pow(*angle - truth, 2), ++errors.raw_frames;
  }
  errors.fitted_deg = RootMean(fitted_sum, errors.frames);
  errors.raw_deg = RootMean(raw_sum, errors.raw_frames);
  errors.seen_deg = RootMean(seen_sum, seen_frames);
  errors.peak_deg = std::max(std::abs(least - true_least), std::abs(most - true_most));
  errors.z_deviation = RootMean(z_sum, errors.frames);
  errors.within_2_sd = errors.frames > 0 ? static_cast<double>(within) / errors.frames : 0;
  return errors;
}

// Says the numbers in the test's report too.
inline void Print(const char* what, std::uint64_t seed, const TrackErrors& e, const KneeErrors& k) {
  std::printf(
      "%s, seed %llu: rms %.4f px, worst %.3f, recall %.2f %%, false %d, border %d, z %.2f, filled %.2f px (%d), knee "
      "%.4f deg, seen %.4f, raw %.4f, peaks %.3f, z %.2f, within 2 sd %.1f %%\n",
      what, static_cast<unsigned long long>(seed), e.rms_px, e.worst_px, 100 * e.recall, e.false_samples,
      e.border_samples, e.z_deviation, e.filled_px, e.filled, k.fitted_deg, k.seen_deg, k.raw_deg, k.peak_deg,
      k.z_deviation, 100 * k.within_2_sd);
}

}  // namespace lake
