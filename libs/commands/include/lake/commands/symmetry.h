// The work of lake-symmetry: what differs between both legs of one person.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lake/compare/misalignment_options.h"
#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/exchange/trial.h"
#include "lake/gait/movement.h"
#include "lake/gait/picture_scale.h"

namespace lake::commands {

struct SymmetryRunOptions {
  std::filesystem::path left, right;  // trials as ReadTrialFor reads them; no right one: the left one shows both legs
  exchange::TrialOptions left_reading, right_reading;
  gait::PictureScale left_picture, right_picture;  // of trials in px
  gait::MovementOptions movement;
  std::filesystem::path forces;               // of a recording of both legs: what each foot bears; or empty
  std::map<std::string, int> plates;          // left, right: which plate, from 1
  std::optional<std::filesystem::path> sync;  // sync.yaml: the forces' clock; else it is the markers'
  double replacement_sd_mm = compare::MisalignmentOptions{}.replacement_sd_mm;
};

void Describe(SymmetryRunOptions& o, OptionList& options);
std::vector<InputFile> InputsOf(const SymmetryRunOptions& options);

// Writes symmetry.csv, symmetry_curve.csv and symmetry.png; returns the results for the summary. Throws Error for
// trials of different units.
Json RunSymmetry(const SymmetryRunOptions& options, Run& run);

}  // namespace lake::commands
