// Measurements of force plates from OpenSim's tables and C3D files.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace lake::exchange {

// One plate over time, in the axes of the laboratory: the force on the foot, a point, and the moment about that point
// (of a table where the force acts, of a C3D file the plate's origin).
struct PlateForces {
  std::string name;  // as the columns begin, without the last underscore: "ground_force_1"
  std::vector<Eigen::Vector3d> force_n, point_m, moment_nm;
  std::string unusable;  // why it has no force, or no point where that acts, which are zero then; empty: it has both
};

struct GroundForceRecording {
  char up_axis = 'y';  // of the laboratory: x, y or z
  std::vector<double> time_s;
  std::vector<PlateForces> plates;  // in the order of the file's columns
  std::vector<std::string> warnings;
};

// A .mot or .sto file with columns NAMEvx, NAMEvy, NAMEvz and NAMEpx … (m), and the moments as NAMEmx … or as OpenSim
// has them, with `torque` for `force` and x, y, z. Missing cells are zero force. Or a .c3d file with force plates of
// types 1 to 4 and 6 of the user guide, at the rate of its analogue channels; the ground pushes, so whichever sign the
// file has, it becomes that of the force on the foot. What an empty plate measures is subtracted, with a warning: its
// mean in the frames that FORCE_PLATFORM:ZERO names, else in those without contact, if there are any. Of several plates
// of a C3D file one that cannot be read is left out with a warning. Throws Error naming the file: no forces, some of a
// plate's absent, no plate that can be read, another ending.
GroundForceRecording ReadGroundForces(const std::filesystem::path& path);

// Whether a file has forces and no markers: a .mot or .sto, or a .c3d without points.
bool HoldsOnlyForces(const std::filesystem::path& path);

// Plates by leg, right and left, counted from 1. Throws UsageError for other legs and numbers, and for one plate of
// both.
void CheckPlates(const std::map<std::string, int>& plates);

// The plate that --plates names for this leg, or the only loaded one. Throws Error listing the plates of the file, or
// saying why the one that is named cannot be read.
const PlateForces& PlateOf(const GroundForceRecording& forces, const std::map<std::string, int>& plates,
                           const std::string& leg, const std::filesystem::path& path);

}  // namespace lake::exchange
