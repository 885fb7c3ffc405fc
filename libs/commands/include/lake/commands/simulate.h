// The paper's graphical simulation as one run: tables, pictures, animation, plates and the mannequin check of a design.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "lake/commands/leg_loads.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/linkage/design_file.h"
#include "lake/linkage/wear.h"
#include "lake/parts/mechanism.h"
#include "lake/problem/problem.h"

namespace lake::commands {

struct SimulationOptions {
  std::vector<double> strokes_mm;  // asked for, added to the table
  std::vector<double> angles_deg;  // poses to draw; none: 2, 70, 110 and the largest whole degree, as far as in range
  double knee_torque_nm = 40;      // for the force column, extension
  std::filesystem::path torques;   // for pin_forces, a torque per stroke or per knee angle; none: knee_torque_nm
  int rows = 201;                  // of the regular grid over the used range
  person::BodySize body;
  double seat_edge_mm = 0;              // knee to the seat's front edge; 0: half the thigh
  bool has_wide_seat = false;           // as linkage::WearOptions has it
  std::optional<linkage::Mount> mount;  // default: the design's
  parts::PartOptions parts;
  LegLoadOptions leg_loads;
  bool animation = true;
  problem::SynthesisProblem load;  // only profile, share, actuator and duration count

  void Check() const;  // throws UsageError
};

void Describe(SimulationOptions& o, OptionList& options);

// A design, by its file or its links, and how to simulate it: with the parts, body and load that it was made for, where
// an option says nothing else.
struct DesignSimulation {
  std::filesystem::path file;
  std::optional<std::array<double, 6>> links;
  double d_min_mm = 0, d_max_mm = 0;  // 0: the design's
  linkage::Design design = {};
  std::filesystem::path absent_load;  // a file of the load that it was made for
  SimulationOptions options;
};
void Describe(DesignSimulation& o, OptionList& options);
Json SimulateLinkage(const DesignSimulation& simulation, Run& run);

std::vector<InputFile> InputsOf(const SimulationOptions& options);

// With a load profile also assistance.csv/.png, with cuffs leg_loads.csv. Writes angle_vs_stroke.csv/.png/.svg,
// pin_forces.csv/.png/.svg, pose_ANGLE.png/.svg, schematic.svg, animation.mp4/.gif, design.dxf, parts.csv, strength.csv
// and mannequin.png through the run and returns what goes into the summary. Throws Error naming stroke and gap if the
// design cannot be assembled at d_min or a stroke asked for, or an angle is out of its range.
Json SimulateLinkage(const linkage::Design& design, const SimulationOptions& options, Run& run);

}  // namespace lake::commands
