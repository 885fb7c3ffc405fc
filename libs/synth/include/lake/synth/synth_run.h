// What lake-synth does: a recording, or a cohort of them, rendered as its options say.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/synth/scene_options.h"

namespace lake::synth {

// What is not given is as in the scene.
struct SynthRunOptions {
  enum class Scene { kClean, kHard };
  enum class Markers { kDisc, kLed, kAruco };
  enum class Drawn { kSitToStand, kWalking };
  Scene scene = Scene::kClean;
  std::uint64_t seed = 1;

  // --- motion ---
  motion::Facing facing = motion::Facing::kRight;
  std::optional<int> repetitions;
  std::optional<std::uint64_t> motion_seed;
  std::optional<double> walk_in_s, second_person_mm, pace, rest_s;
  bool standing = false, still = false, exoskeleton = false;
  double warp = 0, skin_mm = 0;
  std::optional<std::array<double, 2>> exo_knee_mm;
  std::filesystem::path motion_table;
  MotionFile motion;
  Drawn drawn = Drawn::kSitToStand;
  std::optional<double> stride_s, stride_mm;
  std::optional<int> passes;
  bool treadmill = false;

  // --- picture ---
  std::optional<double> duration_s, rate_hz, radius_mm, radius_px, distance_mm, yaw_deg, pitch_deg, roll_deg, level,
      brightness, exposure, shutter, readout_s, flicker, psf_px, read_noise, shot_gain;
  std::optional<int> width_px, height_px, reflections;
  std::filesystem::path camera;
  std::optional<std::array<double, 5>> distortion;
  std::map<std::string, double> depth_mm;
  double hub_mm = 0;
  Markers markers = Markers::kDisc;
  std::vector<Occlusion> occlusions;
  bool bright_room = false, glint = false, colour = false;
  double start_s = 0, jitter = 0;

  // --- files ---
  std::optional<int> crf, people;
  bool lossless = false, pictures = false;
  int sessions = 1;
};

void Describe(SynthRunOptions& o, OptionList& options);

// "clean-1", of which a folder's name is made.
std::string NameOf(const SynthRunOptions& options);

// Writes into the run's folder what WriteRecording or WritePopulation does. Throws Error as they do; UsageError for
// options that contradict each other.
Json RunSynth(const SynthRunOptions& options, Run& run);

}  // namespace lake::synth
