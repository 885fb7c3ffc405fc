// The work of lake-compare: from a human and an exoskeleton trial to the misalignment between their knees.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/commands/functional_knee.h"
#include "lake/compare/misalignment.h"
#include "lake/compare/uncertainty_budget.h"
#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/cuffs/cuff_model.h"
#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/picture_scale.h"
#include "lake/linkage/wear.h"

namespace lake::commands {

struct CompareRunOptions {
  // lake-track folders or files that ReadTrial knows; or folders with a comparison.json (of lake-compare, or the
  // predicted path of lake-optimize), whose human or exoskeleton curve is taken.
  std::filesystem::path human, exo;
  std::string human_knee = "knee";
  std::optional<std::string> exo_knee;  // default: exo_knee, or knee where there is neither
                                        // that nor --exo-segment
  // Of that marker, seen from the joint's axis: anterior, up along the shank.
  std::array<double, 2> joint_at_mm = {0, 0};
  exchange::TrialOptions human_reading, exo_reading;  // of files; a folder's markers have their names already
  gait::PictureScale human_picture, exo_picture;      // of trials in px
  compare::MisalignmentOptions misalignment;
  compare::ComparisonBudgetOptions budget;
  cuffs::CuffOptions cuff;
  KneeOptions knee;
  // The design of the exoskeleton trial: whether seat and limbs of this person allow its joint on the knee.
  std::optional<std::filesystem::path> worn;
  person::BodySize body;      // the leg: that of the human trial
  linkage::WearOptions wear;  // but for the mount, which is the design's, and the placement, which is measured

  bool IsMarkerOnAxis() const { return joint_at_mm == std::array<double, 2>{0, 0}; }
};

void Describe(CompareRunOptions& o, OptionList& options);
std::vector<InputFile> InputsOf(const CompareRunOptions& options);

// What ReadTrialTables reads, or ReadComparison of a folder with a comparison.json. A folder need not be there yet.
std::vector<InputFile> TrialTableInputs(const std::filesystem::path& path, const std::string& role);

// Of a lake-track folder its tables, of another trial, or with a scale of its picture, those of a leg fit. `knee` is
// the compared marker; where the trial has no marker `knee`, it is the leg's knee as well, unless that is rebuilt.
// `given`: the movement, and the trial from which a hidden knee is rebuilt.
compare::TrialTables ReadTrialTables(const std::filesystem::path& path, const exchange::TrialOptions& reading,
                                     const std::string& knee, Run& run, const gait::PictureScale& picture = {},
                                     const gait::LegFitOptions& given = {});

// The same by --knee: with `marker` as it is, with `functional` with the axis about which the person's segments turn:
// of a human trial where the compared marker was, beside an exoskeleton's joint as the marker `knee`. Always of a leg
// fit. Throws UsageError for an exoskeleton trial that shows its joint neither by a marker `knee` other than the leg's
// nor by --exo-segment.
enum class TrialSide { kHuman, kExo };
struct FunctionalTables {
  compare::TrialTables tables;
  std::optional<double> sd_mm;  // of the knee's axis; absent where the trial shows none, and its marker is taken
};
FunctionalTables ReadFunctionalTables(const std::filesystem::path& path, const exchange::TrialOptions& reading,
                                      const std::string& knee, TrialSide side, const KneeOptions& options, Run& run,
                                      const gait::PictureScale& picture = {});

// Throws UsageError for options of a trial that ReadTrialTables would ignore, as a scale is where lengths are in mm.
void CheckReading(const std::filesystem::path& path, const exchange::TrialOptions& reading,
                  const gait::PictureScale& picture = {});

// Writes misalignment.csv, uncertainty_budget.csv, cuffs.csv (where the joint's place on the leg is known),
// overlay.png, misalignment.png, comparison.json, report.html; returns the results for the summary. Throws Error in one
// line for trials that cannot be compared.
Json RunCompare(const CompareRunOptions& options, Run& run);

}  // namespace lake::commands
