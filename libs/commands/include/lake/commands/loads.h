// The work of lake-loads: the moments at ankle, knee and hip over the rise, from a trial and a body mass, with force
// plates or without.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lake/commands/gait.h"
#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/loads/loads.h"

namespace lake::commands {

// The trial and its fit are lake-gait's.
struct LoadsRunOptions : GaitRunOptions {
  loads::LoadsOptions loads;
  std::map<std::string, int> plates;  // right, left: which plate, from 1
  std::string leg;  // right or left; empty: by the markers' names in the file, else right, with a warning
};

void Describe(LoadsRunOptions& o, OptionList& options);

// Writes loads.csv, pace.csv, centre_of_mass.csv, momentum.csv, loads.json, loads.png; returns the results for the
// summary.
Json RunLoads(const LoadsRunOptions& options, Run& run);

}  // namespace lake::commands
