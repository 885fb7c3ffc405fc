// The comparison of a human trial with an exoskeleton trial.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/compare/decomposition.h"
#include "lake/compare/interval.h"
#include "lake/compare/joint_misalignment.h"
#include "lake/compare/knee_axis.h"
#include "lake/compare/metrics.h"
#include "lake/compare/pace_and_posture.h"
#include "lake/compare/registration.h"
#include "lake/core/json.h"

namespace lake::compare {

struct MisalignmentOptions {
  double replacement_sd_mm =
      3;  // per axis: how well a marker is put back on the same spot between trials; 0: one recording
  bool intervals = true;
  std::uint64_t seed = 1;  // of the markers' noise
  double noise_width_percent =
      2;  // correlation width of a filtered marker's noise, about 6 Hz in a natural sit-to-stand
  // A person's own variation between rises, as far as a trial's few repetitions do not show it (the room's README has
  // the people whom it was measured in): standard deviations of how far along the rise is half way through it and of
  // the shank's lean, and how many degrees of freedom they are worth.
  double progress_sd_percent = 4, lean_sd_deg = 1.5, variation_freedom = 4;
  double event_sd_s = 0.02;  // of onset and standing, beside what the fit says of their times
  SpikeOptions spikes;
  DecompositionOptions decomposition;
};

struct MisalignmentIntervals {
  Interval rms_mm, max_mm, relative_rms, relative_max;
  Interval knee_rmse_deg;
};

// Of the parts of the path difference: fractions, RMS in mm, and the fitted offset.
struct PartIntervals {
  std::array<Interval, kParts.size()> fraction, rms_mm;  // in the order of kParts
  Interval offset_x_mm, offset_y_mm;
};

// In each trial: how a person's pace varies from rise to rise looks like timing, so that fewer cannot tell the parts.
inline constexpr int kLeastRepetitionsOfParts = 4;

// The path difference that the exoskeleton trial would have with its joint moved onto the knee, by the mean of the
// joint misalignment: pace and posture stay those of that trial. Its interval holds how rises differ, and how well a
// joint is put where it is meant to be, for which the replacement of a marker stands.
struct JointMoved {
  double rms_mm = 0, relative_rms = 0;
  struct Intervals {
    Interval rms_mm, relative_rms;
  };
  std::optional<Intervals> intervals;
};

struct Misalignment {
  gait::MovementKind movement = gait::MovementKind::kSitToStand;  // of both trials
  StsCurve human, exo;                                            // means over the repetitions
  std::optional<MarkerSight> exo_sight = {};                      // of the exoskeleton's joint
  std::vector<double> shank_mm;                                   // human, per percent
  std::vector<double> distance_mm, misalignment_ratio, misalignment_ratio_paper;
  std::vector<double> misalignment_ratio_sd;  // over all pairs of repetitions; empty for a single pair
  std::vector<bool> spike;
  MisalignmentMetrics metrics, metrics_without_spikes;
  Decomposition decomposition;
  std::optional<MisalignmentIntervals> intervals;
  std::optional<PartIntervals> part_intervals;  // absent below kLeastRepetitionsOfParts
  // RMS that noise alone (marker sigmas or differences between repetitions, and the replacement of markers) would show.
  double noise_floor_mm = 0, noise_floor_relative = 0;
  // Against the exo trial's own leg; absent where that leg is not shown. Its mean is the decomposition's offset then,
  // which without it is the one that explains most of the difference of the paths.
  std::optional<JointMisalignment> joint;
  std::optional<JointMoved> joint_moved;  // absent as `joint`
  // How far the human's mean knee angle is from that of many rises, RMS over the rise: 95 % are nearer. With
  // intervals alone.
  std::optional<double> human_angle_strays_deg;
  Pace pace;
  Posture posture;
  FixedPivot best_pivot;  // of the knee model over the human's range of knee angles
  int human_repetitions = 0, exo_repetitions = 0;
  std::vector<std::string> warnings;
};

// The means over the repetitions are compared. Throws UsageError for an option out of range, Error for trials of two
// movements.
Misalignment CompareTrials(const RegisteredTrial& human, const RegisteredTrial& exo,
                           const MisalignmentOptions& options = {});

// "18 mm in front of the knee and 32 mm above it along the shank": how every text says where a joint sits; shank
// frame, x anterior, y up. Each number is rounded to its half width (95 %), to 1 mm where that is not known.
std::string DescribeJoint(const Eigen::Vector2d& offset_mm, const Eigen::Vector2d& half_width_mm = {0, 0});

// misalignment.csv, 101 rows.
void WriteMisalignmentCsv(const std::filesystem::path& path, const Misalignment& misalignment);

// The content of comparison.json.
Json ComparisonJson(const Misalignment& misalignment);

}  // namespace lake::compare
