// What is measured of each stride of a walk, from one heel strike to the next of the same leg. Terms and phases: Perry
// & Burnfield, Gait Analysis, 2nd ed. (2010), chapters 1 to 4; Winter, Biomechanics and Motor Control of Human Gait
// (1991).
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "lake/core/json.h"
#include "lake/gait/field.h"
#include "lake/gait/leg_fit.h"

namespace lake::gait {

// Standard deviations are the fit's and those of the events' times; lengths are in the plane's unit.
struct GaitCycle {
  int stride = 0;  // as in events.csv
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
std::span<const Field<GaitCycle>> GaitCycleFields();

struct GaitCycles {
  std::vector<GaitCycle> strides;  // the complete ones
  GaitCycle mean;                  // with the standard deviations of the means
  GaitCycle spread;                // values: standard deviations over the strides; NaN of a single one
};

// Of a fit whose movement is walking. `anatomical_sd_deg` of the knee's angle is added to that of its values, not to
// that of its range.
GaitCycles MeasureGaitCycles(const LegFitResult& leg, double anatomical_sd_deg = 0);

// gait_cycles.csv: a row a stride, then `mean` and `sd`; the values, then their standard deviations (…_sd).
void WriteGaitCyclesCsv(const std::filesystem::path& path, const GaitCycles& cycles, motion::LengthUnit of_plane);

// A laboratory's norm of the knee's flexion over the stride.
struct ReferenceCurve {
  std::vector<double> percent, mean_deg, sd_deg;
};

// percent,mean,sd. Throws Error naming file and line: percent that does not increase from 0 or more to 100 or less, a
// negative standard deviation, a single row.
ReferenceCurve ReadReferenceCurve(const std::filesystem::path& path);

// For summaries: by measure mean, sd over strides and coefficient of variation; the ground, complete and incomplete
// strides.
Json GaitCyclesJson(const GaitCycles& cycles, const LegFitResult& leg);

// The main ones in a few lines for the terminal.
std::string GaitCyclesText(const GaitCycles& cycles, const LegFitResult& leg);

}  // namespace lake::gait
