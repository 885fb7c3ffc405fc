// The work of lake-sync: the clocks of two recordings of one movement, aligned by the movement itself or by a signal
// that both have.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/sync/align.h"

namespace lake::commands {

struct SyncRunOptions {
  std::filesystem::path a, b;      // what sync::ReadMovement knows
  std::string signal_a, signal_b;  // a marker that comes into sight, or a column that rises; empty: by the movement
  sync::AlignOptions align;
  sync::MovementOptions reading;
};

void Describe(SyncRunOptions& o, OptionList& options);
std::vector<InputFile> InputsOf(const SyncRunOptions& options);

// Writes sync.yaml and sync.png; returns the results for the summary. Throws Error where the two cannot be aligned.
Json RunSync(const SyncRunOptions& options, Run& run);

}  // namespace lake::commands
