// The work of lake-axis: the axis about which shank and thigh turn, and where it is frame by frame,
// from two or more markers on each, without a leg model.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "lake/axis/functional_axis.h"
#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/exchange/trial.h"

namespace lake::commands {

struct AxisRunOptions {
  std::filesystem::path trial;  // a lake-track folder or a file that ReadPoints knows
  double mm_per_unit = 1;       // of files that do not say their unit
  double rate_hz = 0;           // of files without times
  axis::SegmentMarkers segments;
  double window_s = 0;         // 0: the whole recording only
  double least_turn_deg = 10;  // between two poses of the recording, and of each window
  // Per axis: of the joint against clusters on skin that move as one, which no marker shows. 0: on bone, or a
  // mechanism.
  double soft_tissue_mm = 0;
  std::optional<std::array<double, 2>> range_deg;  // of knee angles, for a pin of its own
};

void Describe(AxisRunOptions& o, OptionList& options);
std::vector<InputFile> InputsOf(const AxisRunOptions& options);

// Writes axis.csv, centre.csv, axis.png/.svg; returns the results for the summary.
Json RunAxis(const AxisRunOptions& options, Run& run);

}  // namespace lake::commands
