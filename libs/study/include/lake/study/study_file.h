// study.yaml: a whole study, from the recordings to a better exoskeleton. Paths are relative to the study file, or to
// `folder` if there is one.
//
//   name, out, folder: texts
//   camera: camera.yaml   or   {calibrate: {images | video, board, plane: {image, board | points}}}
//   human, exo: {video, …} or {trial, …}     exo may be absent
//   compare: {human_knee, exo_knee, replacement_sd_mm, …}
//   design: {problem: file or map, worn: design.yaml, certify_deg, …}
//   reoptimize: {problem, clearances, max_misalignment_percent, program, …}; absent: no design is fitted to the person.
//   With an exo
//     trial either the worn design or human_only: true
//   simulate: {height_mm, mass_kg, seat_edge_mm, …}   the leg's lengths are the human trial's
//   loads: {mass_kg, height_mm, …}; absent: no moments. Of the human trial
//   assistance: {problem, actuator, assist, duration_s, …, or actuators: a catalogue}; absent: no design for what the
//     knee needs; with it `loads`
//   stroke: {duty_table, speed_mm_s, …}; absent: no stroke program
//
// A section has the options of the program that does its work, as keys (core/options.h), but for what the study itself
// gives: the places of trials and designs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "lake/commands/calibrate.h"
#include "lake/commands/compare.h"
#include "lake/commands/gait.h"
#include "lake/commands/loads.h"
#include "lake/commands/optimize.h"
#include "lake/commands/simulate.h"
#include "lake/commands/stroke.h"
#include "lake/commands/track.h"
#include "lake/core/yaml.h"
#include "lake/problem/problem.h"
#include "lake/synthesis/synthesis_outcome.h"

namespace lake::study {

// A file that a study names.
struct StudyInput {
  std::filesystem::path path;
  std::string where;  // "study.yaml:7", for messages
};

// What a section says: as it stands in the study file, but for order, blanks and comments, on which steps depend; and
// as the options of the program that does its work (core/options_json.h), for its summary.
struct StudySection {
  Json text = Json::object(), given = Json::object();
};

// One recording and what is done with it.
struct StudyTrial {
  std::variant<commands::TrackRunOptions, commands::GaitRunOptions>
      work;  // of a video; of a trial that was tracked before
  StudySection section;

  bool IsVideo() const { return std::holds_alternative<commands::TrackRunOptions>(work); }
  const std::filesystem::path& Recording() const;
  gait::LegFitOptions& Fit();
};

struct StudyCalibration {
  commands::CalibrateRunOptions camera;
  std::optional<commands::PlaneRunOptions> plane;  // its camera file is the calibration's
  StudySection camera_section, plane_section;
};

struct StudyProblem {
  std::optional<std::filesystem::path> file;
  problem::SynthesisProblem problem;  // of the file, or as it stands in the study; default: the paper's
  problem::Clearances clearances;     // of the study, which these of the problem give way to
};

// A design fitted to the person.
struct StudyRedesign {
  commands::ReoptimizeRunOptions options;  // without the places of trials and worn design
  synthesis::SynthesisOptions search;
  StudyProblem design;  // default: the study's own
  StudySection section;
};

// What the knee needs, and the links with which an actuator gives it.
struct StudyAssistance {
  commands::OptimizeRunOptions options;  // without the profile
  StudySection section;
};

struct StudyFile {
  std::filesystem::path file;
  std::string name;
  std::optional<std::filesystem::path> out;
  std::optional<std::filesystem::path> camera;  // made before
  std::optional<StudyCalibration> calibration;  // or made by the study
  StudyTrial human;
  std::optional<StudyTrial> exo;
  commands::CompareRunOptions compare;  // without the trials' places
  StudySection compare_section;
  StudyProblem design;
  synthesis::SynthesisOptions optimum;        // how the design's optimum is sought, proved and judged
  std::optional<std::filesystem::path> worn;  // the design worn in the exo trial
  StudySection design_section;
  std::optional<StudyRedesign> redesign;
  std::optional<commands::LoadsRunOptions> loads;  // without the trial's place
  StudySection loads_section;
  std::optional<StudyAssistance> assistance;
  commands::SimulationOptions simulation;
  StudySection simulation_section;
  std::optional<commands::StrokeRunOptions> stroke;  // without the design and the motion's place
  StudySection stroke_section;
  std::vector<StudyInput> inputs;  // all files named, each once

  // In the place of what trials and comparison say of it.
  void SetMovement(gait::MovementKind movement);

  // The folder for the results: `out`; else a name below lake-out, that of the file or, of a study.yaml, of its folder.
  std::string ResultName() const;
};

// Throws Error in one line with file and line: an unknown key, a value that cannot be, markers that do not fit; or with
// all files that are missing.
StudyFile ReadStudyFile(const std::filesystem::path& path);

// A design for the people of a cohort: a section like `reoptimize` with across, quantile and sizes too, its paths
// relative to `folder`. Throws Error with file and line.
StudyRedesign ReadPopulation(YamlNode node, const std::filesystem::path& folder);

// Every key of every section, with its default and what it means. What may be left out stands behind a '#'; the rest is
// a study of human.mp4, exo.mp4 and camera.yaml beside the file.
std::string StudyTemplate();

}  // namespace lake::study
