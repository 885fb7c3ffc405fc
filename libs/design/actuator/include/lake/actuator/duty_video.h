// A log of duties and a video of the actuator that was tracked beside it, brought together: the strokes of a duty
// calibration without a potentiometer.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/actuator/duty_calibration.h"

namespace lake::actuator {

// Duties over time as the firmware logged them; time_s ascends.
struct DutyCommands {
  std::string name;
  std::vector<double> time_s, duty;
};

// As ReadDutyLog, but without strokes.
DutyCommands ReadDutyCommands(const std::filesystem::path& path);

// The actuator's length in a video: the distance of a marker on its body from one on its rod, mm.
struct ActuatorFilm {
  std::vector<double> time_s, length_mm;
};

struct AlignedLog {
  DutyLog log;         // at the video's frames, in the log's time; frames at which a duty begins or ends are left out
  double shift_s = 0;  // the log's time at the video's time 0
  double correlation = 0;  // of duty and speed at that shift, 1 or -1 if they were proportional
};

// The shift at which duty and speed of the film agree best: the largest inner product over all overlaps, to 5 ms.
// Throws Error if log or film are too short, or the correlation is below 0.7: then they are not of the same motion.
AlignedLog AlignWithFilm(const DutyCommands& commands, const ActuatorFilm& film);

}  // namespace lake::actuator
