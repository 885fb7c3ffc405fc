// The work of lake-optimize: the links with the largest range of rotation, or, with a human's motion, the redesign.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/commands/functional_knee.h"
#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/exchange/trial.h"
#include "lake/redesign/redesign_problem.h"
#include "lake/synthesis/synthesis_outcome.h"

namespace lake::commands {

// Without a limit of its own the angle's mismatch is at most 5 degrees where the joint's misalignment is limited.
struct ReoptimizeRunOptions : redesign::MotionLimits {
  std::vector<std::filesystem::path> comparisons;  // folders of lake-compare: human and exoskeleton trial; several:
                                                   // one design for all …
  std::filesystem::path human;                     // … or a human trial alone, as lake-compare reads it; one of both
  std::string human_knee = "knee";                 // the compared marker of the human trial
  KneeOptions knee;                                // of `human`; a comparison has its own, and must have been made so
  exchange::TrialOptions human_reading;            // of files; a folder's markers have their names already
  std::vector<std::filesystem::path> worn;  // design.yaml worn in the exoskeleton trial, one of all or one for each;
                                            // required with one
  bool human_only = false;                  // the exoskeleton trial of the comparison is left out
  std::filesystem::path body;               // loads.json of the human trial; empty: the body is not known
  loads::Aids aids;                         // that the person has in balance
  std::optional<int> pareto_points;
  redesign::Across across = redesign::Across::kWorst;
  double quantile = redesign::GroupProblem{}.quantile;
  std::optional<int> sizes;            // so many designs instead of one for all
  std::filesystem::path participants;  // participants.tsv with heights for the rule; empty: none
  std::vector<double> heights_mm;      // of `comparisons`, or empty
  std::vector<std::string> people;     // whose comparisons these are; empty: named after their folders
};

void Describe(ReoptimizeRunOptions& o, OptionList& options);

struct OptimizeRunOptions {
  problem::SynthesisProblem problem;
  std::filesystem::path problem_file;  // that it was read from, for the record; empty: none
  synthesis::SynthesisOptions study;
  std::filesystem::path actuators;  // a catalogue: each of its actuators instead of one problem; empty: none
  std::optional<ReoptimizeRunOptions> reoptimize;
};

// The problem, its file and how its optimum is sought; the redesign's stand by themselves.
void Describe(OptimizeRunOptions& o, OptionList& options);
std::vector<InputFile> InputsOf(const OptimizeRunOptions& options);

// Writes design.yaml, the tables and figures of the study, with a load profile assistance.csv and .png; of a catalogue
// of actuators actuators_front.csv and .png alone. Returns the results for the summary. Where no design satisfies the
// problem, the nearest and the reason are written, summary.json included, and SolverError is thrown.
Json RunOptimize(const OptimizeRunOptions& options, Run& run);

}  // namespace lake::commands
