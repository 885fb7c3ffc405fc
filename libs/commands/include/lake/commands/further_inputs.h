// What lake-gait and lake-track may know beside the trial: the person's quiet standing, force plates, a norm.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"

namespace lake::commands {

struct FurtherInputs {
  std::filesystem::path neutral;              // quiet standing: a trial, or FROM,TO (s) of this one; empty: none
  std::filesystem::path reference;            // of the knee over the gait cycle, percent,mean,sd; empty: none
  std::filesystem::path forces;               // of force plates; empty: none
  std::optional<std::filesystem::path> sync;  // sync.yaml: the forces' clock; else it is the markers'
};

void Describe(FurtherInputs& o, OptionList& options);
void DescribeForces(FurtherInputs& o, OptionList& options);  // --forces and --sync alone
std::vector<InputFile> InputsOf(const FurtherInputs& o);

// Reads norm, forces and clock, to be known as wrong before minutes of tracking. Throws Error naming the file.
void CheckFiles(const FurtherInputs& o);

// The plates' contacts on the trial's clock; none without --forces. Throws Error where plates and markers have
// different verticals.
std::vector<gait::PlateContact> ContactsOf(const FurtherInputs& o, const exchange::Trial& trial, Run& run);

// The pose of quiet standing, if it is given: of the fit itself, or of another trial of the same markers, which is read
// as `reading` says and seen in the plane of `trial`. Throws as gait::NeutralPose does.
void SetNeutral(const FurtherInputs& o, const exchange::Trial& trial, exchange::TrialOptions reading,
                const gait::LegFitOptions& fit, Run& run, gait::LegFitResult& leg);

}  // namespace lake::commands
