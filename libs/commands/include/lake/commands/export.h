// A design for other programs: simulators, CAD, cutters.
#pragma once

#include <filesystem>
#include <string>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/parts/mechanism.h"

namespace lake::commands {

struct ExportOptions {
  std::filesystem::path design;
  std::string format;  // mjcf, sdf, urdf, step, dxf
  parts::PartOptions parts;
};
void Describe(ExportOptions& o, OptionList& options);

// Writes design.xml (mjcf), design.sdf, design.urdf, design.step or design.dxf, with parts.csv, through the run and
// returns what goes into the summary. Throws UsageError for another format, Error if the design cannot be assembled at
// d_min.
Json RunExport(const ExportOptions& options, Run& run);

}  // namespace lake::commands
