// One trial file into another format: what `lake convert` does.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/options.h"
#include "lake/exchange/trial.h"
#include "lake/gait/picture_scale.h"

namespace lake::exchange {

struct ConvertOptions {
  gait::PictureScale picture;                   // of positions in px
  TrialOptions reading;                         // names, vertical, direction the subject faces, units of the input
  std::string unit = "mm";                      // of a TRC file that is written: mm, cm or m
  std::optional<std::array<double, 2>> crop_s;  // the times that are kept, both ends included
  std::optional<motion::Side> leg;              // of a MOT file; else what the summary beside kinematics.csv says
  bool flexion_negative = false;                // knee angle of a MOT file as OpenSim's older models have it
};

void Describe(ConvertOptions& o, OptionList& options);

// The rate of files without times.
Option& DescribeRate(double& rate_hz, OptionList& options);

// Reads `in`, writes `out` in the format of its ending; returns warnings. Points in space are kept in space where the
// format allows it: turned so that y is up for TRC, with x forward, y up and z to the right if `forward` is given;
// formats of a plane get them projected. Px with a scale become mm where the format holds no px, and with `picture`
// wherever it holds mm. A .mot is made from kinematics.csv or a folder that has one, or from another .mot or .sto.
// Throws Error or UsageError, also for a .mot of a leg whose side is unknown.
std::vector<std::string> ConvertFile(const std::filesystem::path& in, const std::filesystem::path& out,
                                     const ConvertOptions& options);

}  // namespace lake::exchange
