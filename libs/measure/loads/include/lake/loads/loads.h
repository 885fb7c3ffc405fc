// The moments at ankle, knee and hip over the rise from a chair, with 95 % bands: from the ground's forces, or
// without force plates from the trunk down.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/options.h"
#include "lake/loads/body_path.h"
#include "lake/loads/centre_of_mass.h"
#include "lake/loads/leg_dynamics.h"
#include "lake/loads/trunk_fit.h"
#include "lake/motion/leg_motion.h"

namespace lake::loads {

// What the ground does to the leg's foot over time, in the leg frame's axes; moments about their origin.
struct GroundForces {
  std::vector<double> time_s;
  std::vector<Wrench> wrench;
};

// One standard deviation of what tables, markers and plates leave open. Each draw takes all of them anew.
struct Uncertainty {
  double mass = 0.01;              // share of the body's mass
  double segment_mass = 0.10;      // share of a segment's; the trunk takes the rest
  double segment_centre = 0.03;    // of the segment's length
  double segment_gyration = 0.08;  // share
  double trunk_gyration = 0.15;    // share: arms and head move
  // Of --share, of the trunk. Absent: --share is not given, and every share from none to all is as likely. In a rise
  // the legs of healthy people bear 50 % of the weight each (Burnett et al. 2011, doi 10.1016/j.jelekin.2011.03.006),
  // those beside a knee with osteoarthritis 10 % more than it (Turcot et al. 2012, doi 10.1016/j.gaitpost.2012.01.005),
  // those beside a paretic leg 61 % (296 and 458 N: Eng & Chu 2002, doi 10.1053/apmr.2002.33644), and single people
  // more.
  std::optional<double> trunk_share;
  double joint_m = 0.01;  // per axis: how far a marker is from the joint's axis (of the hip 1.5 times)
  // The knee's axis against the plane's normal: the plane in which lateral markers move most was off by up to 18°. The
  // frontal moment at the knee against the extending one.
  double axis_yaw_rad = 0.16, frontal_moment = 0.3;
  double ground_force = 0.01;  // share, of a plate
  double pressure_m = 0.005;   // of a plate's centre of pressure
};

struct LoadsOptions {
  BodyOptions body;
  TrunkPrior trunk;
  Uncertainty uncertainty;
  // −3 dB of the low-pass of positions and forces. With plates the custom; without them the trunk's accelerations
  // decide, and what markers show of them above some 4 Hz is skin and spine (the room's README).
  double cutoff_with_forces_hz = 6, cutoff_hz = 4;
  double seat_release_s = 0.1;   // after seat-off the seat still bears a part for so long
  double seat_contact_s = 0.15;  // before `seated` it bears one again
  std::optional<double> rise_s;  // another time for the rise: what the same path needs then
  int draws = 400;
  std::uint64_t seed = 1;
};

// Those of a user: of the body, how many draws, their seed.
void Describe(LoadsOptions& o, OptionList& options);

constexpr int kPercents = 101;

// One percent of a rise. NaN where not known. Moments of one leg, extension positive.
struct LoadsRow {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  double time_s = kUnknown;  // of the trial; of the mean: since the onset
  double knee_deg = kUnknown, knee_deg_s = kUnknown;
  double ankle_nm = kUnknown, knee_nm = kUnknown, hip_nm = kUnknown;
  double knee_sd_nm = kUnknown;
  // 95 % of the draws; where the seat bears an unknown part, bounds: without the seat, and with the weight and a push
  // along the floor on it.
  double knee_low_nm = kUnknown, knee_high_nm = kUnknown;
  double zmp_mm = kUnknown;          // where the ground's force acts, before the ankle
  double ground_force_n = kUnknown;  // vertical, on this foot
  double knee_power_w = kUnknown;    // positive: the knee gives
};

struct Peak {
  double knee_nm = 0, low_nm = 0, high_nm = 0;  // of the curve, and 95 % of the draws' own peaks
  double knee_deg = 0, percent = 0;
};

// One standard deviation of what RiseMomentum has, of the draws: tables, markers, the trunk's centre,
// the events' times.
struct MomentumSd {
  double seat_off_m = 0, forward_seat_off_m_s = 0, forward_max_m_s = 0, upward_max_m_s = 0;
};

struct RiseLoads {
  int repetition = 0;  // 0: the mean of all
  double onset_s = 0, seat_off_s = 0, standing_s = 0;
  std::vector<LoadsRow> rows;  // 0..100 %
  Peak peak;
  double knee_energy_j = 0;  // the knee's work from where its moment is known to standing
  RiseMomentum momentum;     // of the whole body; not of the mean
  MomentumSd momentum_sd;
};

// The same path gone along evenly in another time. What lies outside the foot cannot be held: along this path the
// person falls, unless something else holds.
struct PaceRow {
  double percent = 0, time_s = 0;
  double knee_nm = 0;    // as in LoadsRow
  double zmp_mm = 0;     // where the ground's force has to act, before the ankle
  double margin_mm = 0;  // how far that is inside the foot; negative outside
};

struct PaceLoads {
  double rise_s = 0;
  std::vector<PaceRow> rows;  // the mean of the rises, from where the seat bears nothing
  double margin_mm = 0;       // the least
  double at_percent = 0;      // where it is
};

struct Balance {
  PaceLoads own, slow;                                     // at the person's own pace, and as slowly as may be
  double slow_margin_low_mm = 0, slow_margin_high_mm = 0;  // 95 % of the draws
  // The longest time in which the path can be gone along in balance; absent: any time, or not even the person's own,
  // where the model is too rough to say.
  std::optional<double> slowest_s;
  std::optional<PaceLoads> asked;  // in LoadsOptions::rise_s
};

struct LoadsResult {
  bool from_ground = false;
  const char* repetition = "rise";  // or "stance"
  LegBody body;
  std::vector<RiseLoads> rises;
  RiseLoads mean;
  Eigen::Vector2d trunk_offset_mm = Eigen::Vector2d::Zero();  // along and across, from where the table has the centre
  Eigen::Vector2d trunk_offset_sd_mm = Eigen::Vector2d::Zero();
  bool has_shoulder = false;
  Balance balance;
  BodyPath body_path;  // with the trunk that the balance is computed with
  // 95 % of the draws, without plates: the part of the body's weight that this leg bears.
  std::array<double, 2> weight_share = {0, 0};
  std::vector<std::string> warnings;
};

// `trajectory`, `motion` and `events`: the leg fit's, in mm. Throws Error: no seat-off in the recording, no trunk,
// forces of another time, forces that pull the foot down or act a metre away from it; UsageError: a body that nobody
// has.
LoadsResult FindLoads(const motion::MarkerRecording& trajectory, const motion::LegMotion& motion,
                      const std::vector<motion::StsEvent>& events, const LegPathOptions& path,
                      const LoadsOptions& options, const std::optional<GroundForces>& forces = {});

// From a foot's heel strike on a plate to its toe-off.
struct Stance {
  int repetition = 0;
  double begin_s = 0, end_s = 0;
};

// Of a walk, over these stances (at least one): what is worked out from the ground up alone, rises being the stances.
LoadsResult FindStanceLoads(const motion::MarkerRecording& trajectory, const motion::LegMotion& motion,
                            const std::vector<Stance>& stances, LegPathOptions path_options, LoadsOptions options,
                            const GroundForces& forces);

}  // namespace lake::loads
