// What force plates measured, as OpenSim's tables have it.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "lake/exchange/trial.h"

namespace lake::exchange {

// One plate over time, in the axes of the laboratory: the force on the foot, where it acts, and the free moment.
struct PlateForces {
  std::string name;  // as the columns begin, without the last underscore: "ground_force_1"
  std::vector<Eigen::Vector3d> force_n, point_m, moment_nm;
};

struct GroundForceRecording {
  std::vector<double> time_s;
  std::vector<PlateForces> plates;  // in the order of the file's columns
};

// A .mot or .sto file with columns NAMEvx, NAMEvy, NAMEvz and NAMEpx … (m), and the moments as NAMEmx … or as OpenSim
// has them, with `torque` for `force` and x, y, z. Missing cells are zero force. Throws Error naming the file: no such
// columns, some of a plate's absent, another ending.
GroundForceRecording ReadGroundForces(const std::filesystem::path& path);

// "right=1,left=2" as plates by leg, counted from 1. Throws UsageError.
std::map<std::string, int> ParsePlates(const std::string& text);

// The plate that --plates names for this leg, or the only one that bears a force. Throws Error listing what the
// file has.
const PlateForces& PlateOf(const GroundForceRecording& forces, const std::map<std::string, int>& plates,
                           const std::string& leg, const std::filesystem::path& path);

}  // namespace lake::exchange
