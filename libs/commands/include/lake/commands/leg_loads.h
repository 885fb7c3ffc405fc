// What the leg bears of a design's moment at the knee and of its weight, through the cuffs that hold it.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/cuffs/leg_statics.h"

namespace lake::commands {

struct LegLoadOptions {
  cuffs::CuffOptions cuffs{.thigh = {}, .shank = {}};  // none: not asked for; the links' masses are below
  std::optional<double> thigh_link_kg, shank_link_kg;  // default: by the design's parts
  std::optional<double> max_leg_shear_n, max_cuff_force_n;

  bool AreAsked() const { return !cuffs.thigh.empty(); }
  void Check() const;  // throws UsageError
};
void Describe(LegLoadOptions& o, OptionList& options);

struct KneeMoment {
  double stroke_mm = 0, knee_deg = 0;
  double moment_nm = 0;  // the device's, extending the knee; NaN where it is not known
};

struct LegLoadRow {
  KneeMoment at;
  cuffs::LegStatics leg;
};

// Of an upright shank, the thigh by the knee's angle: a linkage knows of no more.
std::vector<LegLoadRow> LegLoadsOf(const std::vector<KneeMoment>& moments, const cuffs::CuffOptions& worn);

// stroke_mm, knee_deg, moment_nm, thigh_cuff_n, shank_cuff_n, knee_shear_n, knee_compression_n.
void WriteLegLoads(const std::filesystem::path& path, const std::vector<LegLoadRow>& rows);

// The largest of each and where, a line; said to the person at the terminal, and the part of the summary. Warns of
// limits that are exceeded, and of moments that the cuffs cannot bear.
Json ReportLegLoads(const std::vector<LegLoadRow>& rows, const LegLoadOptions& options, Run& run);

}  // namespace lake::commands
