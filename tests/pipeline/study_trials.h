// Studies of marker files, quick to make and to run: what a study does, without the minutes of videos.
#pragma once

#include <filesystem>
#include <random>
#include <string>

#include "lake/core/atomic_file.h"
#include "lake/motion/marker_recording.h"
#include "lake/study/study.h"
#include "lake/synth/sts_motion.h"
#include "temporary_folder.h"

namespace lake {

// What a camera would have seen of a motion at 60 Hz, with noise of 0.1 mm; until `end_s` if it is given.
inline motion::MarkerRecording RecordingOf(const synth::MarkerMotion& motion, unsigned seed, double end_s = INFINITY) {
  constexpr double kRateHz = 60, kSigmaMm = 0.1;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, kSigmaMm);
  motion::MarkerRecording recording;
  recording.unit = motion::LengthUnit::kMm;
  for (const std::string& name : motion.Names()) recording.markers.push_back({name, {}});
  for (int i = 0; i / kRateHz < std::min(motion.DurationS(), end_s); ++i) {
    recording.frame.push_back(i);
    recording.time_s.push_back(i / kRateHz);
    const std::vector<Eigen::Vector2d> at = motion.At(i / kRateHz);
    for (std::size_t m = 0; m < at.size(); ++m) {
      const double x = normal(random), y = normal(random);
      recording.markers[m].samples.push_back(
          {at[m] + Eigen::Vector2d(x, y), kSigmaMm, motion::SampleStatus::kDetected});
    }
  }
  return recording;
}

inline synth::StsMotionOptions HumanMotionOptions() {
  synth::StsMotionOptions options;
  options.seed = 41;
  options.repetitions = 2;
  options.min_rest_s = 0.8;
  return options;
}

// The same movement, its joint 18 mm in front of the knee and 32 mm above it.
inline synth::StsMotionOptions ExoMotionOptions() {
  synth::StsMotionOptions options = HumanMotionOptions();
  options.pace = 1.25;
  options.exo_knee_mm = Eigen::Vector2d(18, 32);
  return options;
}

// For what does not look at the linkage moving: most of a simulation's time.
inline constexpr const char* kNoAnimation = "simulate: {animation: false}\n";

// A study file with both trials beside it, and its results; as it is made, it simulates without the animation.
class StudyFolder {
 public:
  StudyFolder() {
    WriteTrial("human.csv", RecordingOf(synth::StsMotion(HumanMotionOptions()), 1));
    WriteTrial("exo.csv", RecordingOf(synth::StsMotion(ExoMotionOptions()), 2));
    WriteStudy(kNoAnimation);
  }

  void WriteTrial(const std::string& name, const motion::MarkerRecording& recording) {
    motion::WriteMarkerCsv(folder_ / name, recording);
  }

  // What follows the trials.
  void WriteStudy(const std::string& rest) {
    WriteTextFile(folder_ / "study.yaml", "name: Quick\nhuman: {trial: human.csv}\nexo: {trial: exo.csv}\n" + rest);
  }

  Json Go() {
    const std::string study = (folder_ / "study.yaml").string();
    Run run({"lake-run", "lake run study.yaml", {{"study", study}}, Out(), true});
    return run.WriteSummary(study::RunStudyFile(study::ReadStudyFile(folder_ / "study.yaml"), run));
  }

  // The names of the steps that this run did.
  std::vector<std::string> Done(const Json& summary) const {
    std::vector<std::string> names;
    for (const Json& step : summary["steps"])
      if (step["done"].get<bool>()) names.push_back(step["name"]);
    return names;
  }

  std::filesystem::path Out() const { return folder_ / "out"; }
  const TemporaryFolder& Folder() const { return folder_; }

 private:
  TemporaryFolder folder_;
};

}  // namespace lake
