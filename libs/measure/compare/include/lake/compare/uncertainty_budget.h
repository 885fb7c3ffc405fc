// What each headline of a comparison or of one recording is uncertain by, and why: a budget after the GUM (JCGM
// 100:2008, 5.1).
//
//   u(y)² = Σ (c_i u_i)²,   c_i = ∂y/∂x_i;  intervals of 95 % are y ± 1.96 u.
//
// How precisely the markers are measured and how far they show the joint beneath them are two questions: each headline
// has an interval of both kinds.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/compare/interval.h"
#include "lake/compare/knee_axes.h"
#include "lake/compare/misalignment.h"
#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/gait/leg_fit.h"

namespace lake::compare {

inline constexpr double kSkinDepth_mm = 10;
inline constexpr double kJointDepth_mm = 30;  // hubs stand 20 to 60 mm proud
inline constexpr double kViewSlope = 0.1;     // 0.3 m at 3 m

// Standard deviations of what no trial shows of itself.
struct BudgetOptions {
  // Per axis, of the knee's marker against the joint beneath it. Skin markers deviate from bone pins by up to 13.0 mm
  // in walking and 16.1 mm in cutting (Benoit et al. 2006); single markers on leg and thigh by 4 to 16 mm against
  // fluoroscopy (Ancillao et al. 2021). Such a largest deviation is some two standard deviations.
  double soft_tissue_mm = 7;
  // Of one marker's distance from the plane against another's; unset: what --depth says of the joint's, else
  // kSkinDepth_mm or, of a joint of which nothing is said, kJointDepth_mm.
  std::optional<double> depth_mm = {};
  // How far a marker stands from the camera's axis over its distance; unset: as the trial's camera saw it, else
  // kViewSlope.
  std::optional<double> view_slope = {};
  double scale_percent = 0.2;  // of the plane's scale
  double event_s = 0.02;       // of onset and standing
  KneeAxes axes{};             // no option: the trials tell
};

void Describe(BudgetOptions& o, OptionList& options);

// Of two trials.
struct ComparisonBudgetOptions : BudgetOptions {
  // The soft tissue of a single frame; unset: twice soft_tissue_mm, what is published as the largest one. Skin slides
  // as the knee bends: over rises, squats, stairs, a jump and walking the knee's marker strayed from the knee of
  // skeletal models by 6 to 14 mm per axis about its mean, of which a mean over the rise keeps a part only.
  std::optional<double> frame_tissue_mm = {};

  double FrameTissueMm() const { return frame_tissue_mm.value_or(2 * soft_tissue_mm); }
};

void Describe(ComparisonBudgetOptions& o, OptionList& options);

// Of one recording, whose markers were placed once.
struct RecordingBudgetOptions : BudgetOptions {
  double placement_mm = 3;  // per axis, of the marker's spot on the skin against that of another day or examiner
};

void Describe(RecordingBudgetOptions& o, OptionList& options);

inline constexpr const char* kDetection = "detection";  // source of each budget's row of the markers' own noise

struct BudgetRow {
  std::string source;
  std::string distribution;  // normal, uniform, t
  double size = 0;           // standard deviation of the source
  std::string unit;          // of the size
  double sensitivity = 0;    // the headline's unit per the size's unit
  std::string reference;
  bool is_of_markers = false;  // precision of the markers; else accuracy with respect to the joint

  double Contribution() const { return sensitivity * size; }
};

struct Budget {
  std::string quantity;  // joint_rms, joint_offset_x, joint_offset_y, joint_frame, knee_angle, rise
  std::string unit;      // mm, deg or s
  double value = 0;
  double least = 0;  // of the quantity's values: 0 for a root mean square
  std::vector<BudgetRow> rows;
  // Of a size, √(|offset|² + rest²): the offset, its deviation along the axis that it is known worse along, and how
  // much of the rest may be the skin's. Chance makes a small offset larger, whichever way it goes.
  struct Size {
    double offset_mm = 0, marker_sd_mm = 0, sd_mm = 0, skin_mm = 0;
  };
  std::optional<Size> size = {};

  double MarkerDeviation() const;
  double Deviation() const;  // of all sources
  Interval MarkerInterval() const;
  Interval AnatomicalInterval() const;
  double SharePercent(const BudgetRow& row) const;  // of the variance
};

// None of the joint's headlines where the trial does not show the leg's own knee. `replacement_sd_mm` as in
// MisalignmentOptions.
std::vector<Budget> BudgetsOf(const Misalignment& misalignment, double replacement_sd_mm,
                              const ComparisonBudgetOptions& options);

// Of one recording: the knee angle of a frame, and the mean time of a rise. None where its lengths are in px.
std::vector<Budget> BudgetsOf(const gait::LegFitResult& leg, const RecordingBudgetOptions& options);

// Of the joint's place against the knee beneath the skin, along the axis that it is known worse along, mm; NaN without
// the joint's headlines.
double PlaceDeviation(const std::vector<Budget>& budgets);

// Of the joint's depth against the knee's, where it is corrected by this one, if by any.
double JointDepthDeviationMm(const std::optional<gait::MarkerDepth>& depth, const BudgetOptions& options);

// What that leaves open of the joint's mean place against the knee, shank's frame: of `misalignment` only `exo` and
// `exo_sight` are looked at.
Eigen::Vector2d ParallaxDeviationMm(const Misalignment& misalignment, const BudgetOptions& options);

// As people read it: "joint misalignment, RMS".
std::string QuantityName(const std::string& quantity);

// What would narrow the interval, in a sentence: the largest source first, then what can be done about those of 1 % of
// the variance and more.
std::string WhatNarrows(const Budget& budget);

// uncertainty_budget.csv: a row for each source of each headline.
void WriteUncertaintyBudgetCsv(const std::filesystem::path& path, const std::vector<Budget>& budgets);

// `uncertainty` of comparison.json.
Json BudgetsJson(const std::vector<Budget>& budgets);

}  // namespace lake::compare
