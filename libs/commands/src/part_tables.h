// The parts of a mechanism, as a table and for the summary.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/parts/mechanism.h"

namespace lake::commands {

// parts.csv: a row per part, a bill of materials.
void WritePartList(const std::filesystem::path& path, const parts::Mechanism& mechanism);

// The bodies in each layer, from the leg outwards.
std::vector<std::vector<std::string>> LayersOf(const parts::Stack& stack);

// Mass of plates, pins and spacers, without the actuator.
double MassOf_g(const parts::Mechanism& mechanism);

// Both, for the summary.
Json PartsJson(const parts::Mechanism& mechanism);

// Of what the stacking order does not keep apart.
void WarnOfStack(const parts::Mechanism& mechanism, Run& run);

}  // namespace lake::commands
