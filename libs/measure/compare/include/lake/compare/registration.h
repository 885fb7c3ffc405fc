// Registration: every repetition of a trial (sit-to-stand, or stride of a walk) at 0, 1, … 100 % of its motion, in the
// leg frame. Trials of other frame rates, lengths, facings and cameras become comparable by it.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "lake/gait/leg_view.h"
#include "lake/gait/movement.h"
#include "lake/motion/leg_motion.h"
#include "lake/motion/marker_recording.h"

namespace lake::compare {

inline constexpr int kPercentSamples = 101;

// One repetition, or the mean of several; one value per percent. Positions in mm in the leg frame, x anterior, y up:
// origin at the ankle's median over the seated rests, of walking at the hip of the same instant.
struct StsCurve {
  int repetition = 0;                             // from 1; 0: a mean
  double duration_s = 0;                          // onset to standing, or heel strike to heel strike
  std::optional<double> seat_off_s = {};          // after the onset; of a repetition that has one
  double onset_sd_s = 0, standing_sd_s = 0;       // of the times of 0 and 100 %, from the fit; 0: not known
  std::vector<Eigen::Vector2d> ankle, knee, hip;  // knee: the compared marker
  // The leg's own knee, where another marker is compared; empty: the trial does not show it.
  std::vector<Eigen::Vector2d> leg_knee;
  std::vector<double> knee_deg;
  // Forward lean of shank and trunk (hip to waist); NaN where it is not shown.
  std::vector<double> shank_deg, trunk_deg;
  // Where technical markers replace the leg's own knee, their standard deviation per axis, else 0; empty: they do not.
  std::vector<double> rebuilt_sd_mm = {};
  // How far the compared marker is off for each mm that it stands proud of the plane; empty: not known.
  std::vector<Eigen::Vector2d> slope = {};
  std::vector<double> knee_sigma_mm;  // one standard deviation per axis of the knee relative to the origin
};

// What a trial gives: of a lake-track folder its tables, of another file the result of the leg fit.
struct TrialTables {
  std::string name;                    // for messages
  motion::MarkerRecording trajectory;  // plane frame
  motion::LegMotion motion;            // of the same frames
  std::vector<motion::StsEvent> events;
  std::optional<gait::PlaneSight> sight = {};
};

struct RegistrationOptions {
  std::string ankle = "ankle", hip = "hip";
  std::string knee = "knee";      // the compared marker
  std::string leg_knee = "knee";  // the leg's own
  // Where the compared marker is, seen from the joint's axis: anterior, up along the shank. What is registered is the
  // axis.
  Eigen::Vector2d marker_at_mm = Eigen::Vector2d::Zero();
  double max_gap_s = 0.2;  // a longer gap in a repetition makes it useless
};

// How a calibrated camera saw the compared marker, and the depth that it is corrected by.
struct MarkerSight {
  gait::PlaneSight plane;
  std::optional<gait::MarkerDepth> depth;
};

struct RegisteredTrial {
  std::vector<StsCurve> repetitions;                              // at least one
  std::vector<std::string> warnings;                              // repetitions left out, and why
  gait::MovementKind movement = gait::MovementKind::kSitToStand;  // or kWalking
  std::optional<MarkerSight> sight = {};
};

// Walking where the events have a heel strike, else sit-to-stand.
gait::MovementKind MovementIn(const TrialTables& trial);

// Onset and standing of a repetition that has both; of walking its heel strike and the next one of the same leg.
struct StsInterval {
  int repetition = 0;
  double onset_s = 0, standing_s = 0;
  std::optional<double> seat_off_s = {};
  double onset_sd_s = 0, standing_sd_s = 0;  // 0: not known
};
std::vector<StsInterval> FindStsIntervals(const TrialTables& trial);

// Throws Error: lengths in px, a marker that is absent, no repetition found, or none that is whole, tables that
// contradict each other.
RegisteredTrial RegisterTrial(const TrialTables& trial, const RegistrationOptions& options = {});

// Sample by sample. `curves` must not be empty.
StsCurve MeanCurve(const std::vector<StsCurve>& curves);

// |AK| in mm.
std::vector<double> ShankLengths(const StsCurve& curve);

// A frame along an axis that points up the leg: columns x anterior, y along it.
Eigen::Matrix2d AxesAlong(const Eigen::Vector2d& up_the_leg);

// The shank frame at a sample: columns x anterior, y from ankle to knee.
Eigen::Matrix2d ShankAxes(const StsCurve& curve, std::size_t sample);

}  // namespace lake::compare
