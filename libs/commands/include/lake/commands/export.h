// A design for other programs: simulators, CAD, cutters.
#pragma once

#include <filesystem>
#include <string>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/cuffs/cuff_model.h"
#include "lake/parts/mechanism.h"

namespace lake::commands {

struct ExportOptions {
  std::filesystem::path design;
  std::string format;  // mjcf, osim, urdf, step, dxf
  parts::PartOptions parts;
  // With a body (loads.json of a person) mjcf and osim are of the mechanism worn, in a motion that lake-optimize or
  // lake-compare wrote; without one of its own, the design's `predicted`.
  std::filesystem::path body, motion;
  cuffs::CuffOptions cuffs;
};
std::vector<InputFile> InputsOf(const ExportOptions& options);

void Describe(ExportOptions& o, OptionList& options);

// Writes design.xml (mjcf), design.osim, design.urdf, design.step or design.dxf, with parts.csv and, of a worn
// mechanism, course.csv (and course.mot beside an osim), through the run and returns what goes into the summary.
// Throws UsageError for another format, Error if the design cannot be assembled at d_min.
Json RunExport(const ExportOptions& options, Run& run);

}  // namespace lake::commands
