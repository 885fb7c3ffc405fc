// From logs of an actuator driven at constant duties to its duty table.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lake/actuator/duty_table.h"
#include "lake/actuator/stroke_schedule.h"

namespace lake::actuator {

// A log: times ascending; stroke in mm as measured, never as planned; duty signed, -1..1, positive extends.
struct DutyLog {
  std::string name;
  std::vector<double> time_s, stroke_mm, duty;
};

// Two readings of the potentiometer with their strokes: the line between them is its scale.
struct PotentiometerScale {
  double counts_a = 0, mm_a = 0, counts_b = 0, mm_b = 0;
};

// "C0=MM0,C1=MM1". Throws UsageError.
PotentiometerScale ParsePotentiometerScale(const std::string& text);

// A CSV with time_s, duty and stroke_mm, or the firmware's serial output with `adc` and a scale; what the firmware says
// between its rows is passed over, as are lines that start with '#' and repeated headers. Rows without a stroke are
// left out. Throws Error naming file and line: times that do not ascend, a duty outside -1..1, no stroke column.
DutyLog ReadDutyLog(const std::filesystem::path& path, const std::optional<PotentiometerScale>& scale);

// The same of a log whose strokes another measurement has: the duties alone.
DutyLog ReadDutyCommands(const std::filesystem::path& path);

struct AlignedLog {
  DutyLog log;         // at the video's frames, in the log's time; frames at which a duty begins or ends are left out
  double shift_s = 0;  // the log's time at the video's time 0
  double correlation = 0;  // of duty and speed at that shift, 1 or -1 if they were proportional
};

// A log of duties and a video of the actuator that was tracked beside it: the lengths between a marker on its body and
// one on its rod are the strokes of a calibration without a potentiometer. The shift at which duty and speed of the
// film agree best: the largest inner product over all overlaps, to 5 ms. Throws Error if log or film are too short, or
// the correlation is below 0.7: then they are not of the same motion.
AlignedLog AlignWithFilm(const DutyLog& commands, const StrokeSeries& film);

struct CalibrateOptions {
  double settle_s = 0.2;         // left out at the beginning of each plateau: the motor's and the screw's run-up
  double min_plateau_s = 0.4;    // shorter stretches of constant duty are left out
  double still_mm_s = 0.05;      // slower is standing still
  double steady_fraction = 0.1;  // a plateau whose halves differ by more (and by 5 standard errors) is left out: its
                                 // stroke met an end, or the load changed

  void Check() const;  // throws UsageError where min_plateau_s does not exceed settle_s
};

void Describe(CalibrateOptions& o, OptionList& options);

// A stretch of constant duty and its speed.
struct Plateau {
  std::string log;
  double begin_s = 0, end_s = 0, duty = 0;
  double speed_mm_s = 0, standard_error_mm_s = 0;  // signed
  bool used = false;
};

// The edge of the dead band of one direction.
struct DeadBand {
  double duty = 0;
  double low = 0, high = 0;  // the last duty that stood still (0: none was tried) and the first that moved
};

struct DutyCalibration {
  std::vector<DutyRow> rows;  // monotone; the edges of the dead bands are rows of speed 0
  std::vector<Plateau> plateaus;
  DeadBand extend, retract;
  double largest_adjustment_mm_s = 0;       // by the monotone fit
  std::optional<double> tolerance_percent;  // the largest of the rows'; none if no duty was tried twice
  std::vector<std::string> warnings;
};

// Robust slope per plateau; plateaus of one duty are averaged with the larger of their own and their mutual errors;
// speeds are made monotone by the pool-adjacent-violators algorithm (Barlow et al. 1972) weighted by 1/error². The dead
// band ends where the line through the two slowest moving duties meets speed 0, within what was tried. A duty tried at
// least twice in a direction has a tolerance: the largest difference of one of its plateaus from the table, two
// standard errors of the plateau included. It covers only the loads and supplies that were tried. Throws Error if a
// direction has fewer than two moving duties, or moves against its duty.
DutyCalibration CalibrateDuty(const std::vector<DutyLog>& logs, const CalibrateOptions& options);

// The slope of noisy points that some of them cannot spoil.
// Least squares on the points that a first line by Theil & Sen (the median of the slopes of all pairs; Sen 1968,
// doi:10.1080/01621459.1968.10480934) leaves within four robust deviations, or within the step of the readings: the
// median alone would stick to multiples of that step. 29 % of the points may be wrong. Of more than `kMostSlopePoints`
// points, means of equal groups are taken. Slope and error are NaN for fewer than three points or one x.
struct RobustSlope {
  double slope = 0, standard_error = 0;
};
inline constexpr std::size_t kMostSlopePoints = 300;
RobustSlope FitRobustSlope(std::span<const double> x, std::span<const double> y);

}  // namespace lake::actuator
