// Random people, each with a body, a way to rise and an exoskeleton that is donned anew in each session: cohorts with
// known truth.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lake/synth/scene_options.h"

namespace lake::synth {

// Standard deviations between people and, of one person, between sessions. Height and body mass index are as in adult
// populations, lengths of segments the parts of the height in Winter (Biomechanics and Motor Control of Human Movement,
// 4th ed., fig. 4.1), times to rise 1.7 to 2.3 s.
struct PopulationOptions {
  std::uint64_t seed = 1;
  int people = 20, sessions = 1;
  double height_mm = 1710, height_sd_mm = 90;
  double mass_index_kg_m2 = 24, mass_index_sd = 3;
  double seated_knee_deg = 92, seated_knee_sd_deg = 5, seated_knee_session_sd_deg = 1.5;
  double rise_s = 1.95, rise_sd_s = 0.15, rise_session_sd_s = 0.05;
  double pace = 1.2, pace_sd = 0.05;                      // of rises with the exoskeleton
  Eigen::Vector2d exo_knee_mm = {24, 36};                 // of the exoskeleton's joint, anterior and upward of the knee
  double exo_knee_sd_mm = 6, exo_knee_session_sd_mm = 3;  // per axis

  // Throws UsageError below one person or one session.
  void Check() const;
};

struct Session {
  std::string participant, session;  // sub-01, ses-1 (empty if there is one session only)
  double height_mm = 0, mass_kg = 0;
  StsMotionOptions human, exo;

  std::filesystem::path Folder() const;  // sourcedata/sub-01/ses-1
};

// In the order of people, then of sessions. What is not drawn is as in `motion`. A session's trial with exoskeleton is
// its trial without, at another pace and with the exoskeleton's joint: so it is known how they differ.
std::vector<Session> DrawPopulation(const PopulationOptions& options, const StsMotionOptions& motion);

// Renders each session's two trials into Folder()/human and Folder()/exo of `folder`, and writes what `lake cohort`
// reads beside them: participants.tsv and .json, cohort.yaml (which says where in each recording the two knee markers
// are, as the exoskeleton's is no part of the leg), and truth.csv, a row a session. Each scene is `scene` but for its
// motion and seed.
void WritePopulation(const std::vector<Session>& sessions, const SceneOptions& scene,
                     const std::filesystem::path& folder);

}  // namespace lake::synth
