// MOT and STO, the tables of OpenSim: a header up to `endheader`, then columns over time.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/motion/leg_motion.h"

namespace lake::exchange {

struct MotTable {
  std::string name;
  bool in_degrees = true;
  std::vector<std::string> columns;  // without time
  std::vector<double> time_s;
  std::vector<std::vector<double>> rows;   // as wide as `columns`; NaN where missing
  std::vector<std::string> warnings = {};  // of reading: the unit of angles is an assumption

  // Throws Error if there is none.
  std::size_t Column(const std::string& column) const;
};

// Whether the ending is .mot or .sto.
bool IsMot(const std::filesystem::path& path);

// Of the unit of angles counts what the header says, by the key inDegrees or in a sentence. Where it says nothing,
// SIMM's form has degrees, any other radians, as OpenSim reads them, with a warning. Throws Error naming file and line:
// no endheader, a row of another width, counts that contradict the header, a unit that is not understood.
MotTable ReadMot(const std::filesystem::path& path);
void WriteMot(const std::filesystem::path& path, const MotTable& table);

// time, knee_angle_l or knee_angle_r, the tilt of shank, thigh and trunk, and which repetition (of a walk, stride) it
// is at what percent, both 0 between repetitions. OpenSim's older models (gait2392) count flexion negative: then the
// knee's sign is turned. Frames without a knee angle are left out.
MotTable MotFromLegMotion(const motion::LegMotion& motion, motion::Side leg, bool flexion_negative = false);

}  // namespace lake::exchange
