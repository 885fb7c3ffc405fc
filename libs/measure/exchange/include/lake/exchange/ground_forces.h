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

// A foot's load on a plate: from where the vertical force rises above 20 N over what the empty plate reads to where it
// falls below, between samples (Zeni et al. 2008, doi:10.1016/j.gaitpost.2007.07.007); NaN: it bears already when the
// recording begins, or still when it ends. Loads of less than 0.1 s, and gaps of less than 0.05 s, are the plate's
// noise.
struct PlateLoad {
  double begin_s, end_s;
  double begin_sd_s, end_sd_s;  // by the empty plate's noise over the force's slope, and half a sample
};
std::vector<PlateLoad> LoadsOf(const PlateForces& plate, const std::vector<double>& time_s, const Eigen::Vector3d& up);

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
