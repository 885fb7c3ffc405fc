// What is measured of each stride of a walk, from one heel strike to the next of the same leg. Terms and phases: Perry
// & Burnfield, Gait Analysis, 2nd ed. (2010), chapters 1 to 4; Winter, Biomechanics and Motor Control of Human Gait
// (1991).
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "lake/gait/field.h"
#include "lake/gait/leg_fit.h"

namespace lake::gait {

// Standard deviations are the fit's and those of the events' times; lengths are in the plane's unit.
struct GaitCycle {
  static std::span<const Field<GaitCycle>> Fields();

  int repetition = 0;  // of the stride
  Measured begin_s, stride_s, stance_s, stance_percent, swing_s, cadence_steps_min, stride_length, speed;
  Measured knee_heel_strike_deg, knee_loading_deg, knee_stance_min_deg, knee_toe_off_deg, knee_swing_deg,
      knee_range_deg;
  Measured thigh_range_deg, shank_range_deg, trunk_range_deg;
  // With heel and toe markers.
  Measured foot_heel_strike_deg, ankle_heel_strike_deg, ankle_dorsiflexion_deg, ankle_toe_off_deg,
      ankle_plantarflexion_deg, ankle_range_deg;
  // With both legs.
  Measured step_s, step_length, double_support_percent, step_symmetry_percent;
  Measured toe_clearance;  // with a toe marker
};

// The complete strides of a fit whose movement is walking. `anatomical_sd_deg` of the knee's angle is added to that of
// its values, not to that of its range.
Measures<GaitCycle> MeasureGaitCycles(const LegFitResult& leg, double anatomical_sd_deg = 0);

// A laboratory's norm of the knee's flexion over the stride.
struct ReferenceCurve {
  std::vector<double> percent, mean_deg, sd_deg;
};

// percent,mean,sd. Throws Error naming file and line: percent that does not increase from 0 or more to 100 or less, a
// negative standard deviation, a single row.
ReferenceCurve ReadReferenceCurve(const std::filesystem::path& path);

}  // namespace lake::gait
