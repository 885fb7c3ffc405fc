#include "lake/compare/uncertainty_budget.h"

#include <algorithm>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/numbers.h"
#include "lake/core/plausible.h"
#include "lake/core/statistics.h"
#include "lake/gait/sit_to_stand.h"
#include "lake/motion/leg_motion.h"
#include "standard_errors.h"

namespace lake::compare {
namespace {

using Eigen::Vector2d;

constexpr const char* kSoftTissue = "soft tissue";
constexpr const char* kFrameTissue = "soft tissue in a single frame";
constexpr const char* kPlacement = "marker placement";
constexpr const char* kAnkleAndHipTissue = "soft tissue at ankle and hip";
constexpr const char* kAnkleAndHipPlacement = "placement of ankle and hip";
constexpr const char* kAxis = "axis of rotation";
constexpr const char* kParallax = "out-of-plane movement and parallax";
constexpr const char* kPlane = "lens and plane";
constexpr const char* kOwnVariation = "the person's own variation";

constexpr const char* kTissueReference =
    "Benoit et al. 2006, doi:10.1016/j.gaitpost.2005.04.012; Ancillao et al. 2021, PMC8631460; --soft-tissue";

// Of one marker's depth against another's, as a camera sees it.
struct Parallax {
  double size_mm = 0;
  double sensitivity = 0;  // the headline's unit per mm of depth
  const char* reference = "";
};

// What a quantity gains from an error at the knee, the joint or the rise's ends, in its own unit.
struct Sensitivities {
  double constant = 0;     // per mm of a constant error along each axis
  double noise = 0;        // per mm of independent errors of the samples
  double scale = 0;        // per percent of scale
  double event_start = 0;  // per s
  double event_end = 0;    // per s
};

// d(mean)/d(t0) and d(mean)/d(t1) of a mean over the rise.
void SetEvents(double first, double last, double mean, double duration_s, double factor, Sensitivities& s) {
  s.event_start = factor * (mean - first) / duration_s;
  s.event_end = factor * (last - mean) / duration_s;
}

Sensitivities OfRms(const JointMisalignment& joint, double duration_s) {
  Sensitivities s;
  const double rms = joint.rms_mm;
  // d(rms)/d(offset) = mean · direction / rms.
  s.constant = rms > 0 ? joint.mean_mm.norm() / rms : 1;
  s.noise = 1 / std::sqrt(kIndependentSamples);
  s.scale = rms / 100;
  if (rms > 0)
    SetEvents(joint.shank_mm.front().squaredNorm(), joint.shank_mm.back().squaredNorm(), rms * rms, duration_s,
              1 / (2 * rms), s);
  return s;
}

Sensitivities OfOffset(const JointMisalignment& joint, int axis, double duration_s) {
  Sensitivities s{
      .constant = 1, .noise = 1 / std::sqrt(kIndependentSamples), .scale = std::abs(joint.mean_mm[axis]) / 100};
  SetEvents(joint.shank_mm.front()[axis], joint.shank_mm.back()[axis], joint.mean_mm[axis], duration_s, 1, s);
  return s;
}

constexpr const char* kReplacement = "assumed; --replacement-sd";
constexpr const char* kRebuilding = "hidden knee rebuilt from technical markers";

BudgetRow Detection(double size, const char* unit, double sensitivity) {
  return {.source = kDetection,
          .distribution = "normal",
          .size = size,
          .unit = unit,
          .sensitivity = sensitivity,
          .reference = "sigmas of this recording's markers",
          .is_of_markers = true};
}

// Of a marker on the skin. `slope`: how the trial's camera saw it, if that is known.
Parallax OfSkin(const std::optional<double>& slope, double per_mm, const BudgetOptions& o) {
  return {o.depth_mm.value_or(kSkinDepth_mm), o.view_slope.value_or(slope.value_or(kViewSlope)) * per_mm,
          slope ? "slope of this trial's camera, depth assumed; --depth-sd" : "assumed; --depth-sd, --view-slope"};
}

// Of the joint's place against the knee, per mm of its depth: mean along `direction`(percent), shank's frame.
template <typename Direction>
std::optional<double> JointSlope(const Misalignment& m, const Direction& direction) {
  if (m.exo.slope.empty() || !m.exo_sight || m.exo.leg_knee.empty()) return std::nullopt;
  double sum = 0;
  for (std::size_t i = 0; i < m.exo.slope.size(); ++i)
    sum += m.exo.slope[i].dot(AxesAlong(m.exo.leg_knee[i] - m.exo.ankle[i]) * direction(i));
  return sum / static_cast<double>(m.exo.slope.size());
}

// Of the joint against the knee, along the direction in which the headline grows; `assumed` is what it gains per mm in
// any.
template <typename Direction>
Parallax OfJoint(const Misalignment& m, const Direction& direction, double assumed, const BudgetOptions& o) {
  const std::optional<double> slope = JointSlope(m, direction);
  if (!slope || o.view_slope) return OfSkin({}, assumed, o);
  const std::optional<gait::MarkerDepth>& depth = m.exo_sight->depth;
  return {JointDepthDeviationMm(depth, o), *slope,
          depth ? "slope of this trial's camera, depth as --depth says"
                : "slope of this trial's camera; how far the joint stands proud is not known: --depth"};
}

// `placement`: its standard deviation in mm and the option that changes it; an axis has none, but its own, `axis_mm`.
void AddSources(const Sensitivities& s, const Parallax& parallax, BudgetRow detection,
                std::pair<double, const char*> placement, const std::optional<double>& axis_mm, const BudgetOptions& o,
                std::vector<BudgetRow>& rows) {
  rows.push_back(std::move(detection));
  const auto add = [&](const char* source, const char* distribution, double size, const char* unit, double sensitivity,
                       const char* reference, bool is_of_markers) {
    rows.push_back({.source = source,
                    .distribution = distribution,
                    .size = size,
                    .unit = unit,
                    .sensitivity = std::abs(sensitivity),
                    .reference = reference,
                    .is_of_markers = is_of_markers});
  };
  add(kPlane, "normal", o.scale_percent, "%", s.scale, "assumed; --scale-sd", true);
  add(kParallax, "normal", parallax.size_mm, "mm", parallax.sensitivity, parallax.reference, true);
  add("event times", "normal", o.event_s, "s", std::hypot(s.event_start, s.event_end), "assumed; --event-sd", true);
  if (axis_mm)
    add(kAxis, "normal", *axis_mm, "mm", s.constant, "how the markers of shank and thigh move against each other",
        false);
  else
    add(kPlacement, "normal", placement.first, "mm", s.constant, placement.second, false);
  add(kSoftTissue, "normal", o.soft_tissue_mm, "mm", s.constant, kTissueReference, false);
}

// Of a knee that technical markers replace: what its rebuilding may be off by is alike in all repetitions.
void AddRebuilding(const StsCurve& exo, double sensitivity, std::vector<BudgetRow>& rows) {
  if (exo.rebuilt_sd_mm.empty()) return;
  rows.push_back({kRebuilding, "normal", RootMeanSquare(exo.rebuilt_sd_mm), "mm", std::abs(sensitivity),
                  "repetitions that were left out when it was learnt, and where its marker is seen", true});
}

std::vector<double> Norms(const std::vector<Vector2d>& vectors) {
  std::vector<double> norms;
  norms.reserve(vectors.size());
  for (const Vector2d& vector : vectors) norms.push_back(vector.norm());
  return norms;
}

// Of a calibrated plane: its distance is a scale, and a turn moves what stands proud of it.
void AddPlane(const Misalignment& m, std::vector<BudgetRow>& rows) {
  if (!m.exo_sight) return;
  const gait::PlaneSight& plane = m.exo_sight->plane;
  BudgetRow& scale = *std::ranges::find(rows, kPlane, &BudgetRow::source);
  scale.size = std::hypot(scale.size, 100 * plane.distance_sd_mm / plane.camera_mm.z());
  if (m.exo_sight->depth && plane.turn_sd_rad > 0)
    rows.push_back({"turn of the plane", "normal", DegreesFromRadians(plane.turn_sd_rad), "deg",
                    std::abs(RadiansFromDegrees(m.exo_sight->depth->mm)), "the camera file", true});
}

// Of how far the joint is from the knee in a frame. Where an axis is known, the skin's sliding is in it as far as the
// clusters show it.
Budget JointFrameBudget(const Misalignment& m, double replacement_sd_mm, const ComparisonBudgetOptions& o) {
  Budget budget{"joint_frame", "mm", Mean(Norms(m.joint->shank_mm)), 0, {}};
  Sensitivities s;
  s.constant = 1;
  s.noise = std::numbers::sqrt2;  // of both markers
  s.scale = budget.value / 100;
  const auto away = [&](std::size_t i) { return m.joint->shank_mm[i].normalized(); };
  AddSources(s, OfJoint(m, away, s.constant, o), Detection(RootMeanSquare(m.exo.knee_sigma_mm), "mm", s.noise),
             {replacement_sd_mm, kReplacement}, o.axes.exo_mm, o, budget.rows);
  AddPlane(m, budget.rows);
  AddRebuilding(m.exo, s.constant, budget.rows);
  if (o.axes.exo_mm) return budget;
  BudgetRow& tissue = *std::ranges::find(budget.rows, kSoftTissue, &BudgetRow::source);
  tissue.source = kFrameTissue;
  tissue.size = o.FrameTissueMm();
  tissue.reference =
      "Benoit et al. 2006, the largest deviation, and thirteen legs against skeletal models; --frame-tissue";
  return budget;
}

void AddOwnVariation(double sd, const std::string& unit, std::vector<BudgetRow>& rows) {
  rows.push_back({kOwnVariation, "t", sd, unit, 1, "repetitions of this trial", true});
}

// A knee's marker moved across the leg turns shank and thigh against each other.
Sensitivities OfKneeAngle(double shank_mm, double thigh_mm) {
  Sensitivities s;
  s.constant = s.noise = DegreesFromRadians(1 / shank_mm + 1 / thigh_mm);  // of one frame's angle
  return s;
}

// Of the angle alone, as that of a frame hangs on all three markers.
void AddAnkleAndHip(double shank_mm, double thigh_mm, std::pair<double, const char*> placement, const BudgetOptions& o,
                    std::vector<BudgetRow>& rows) {
  const double sensitivity = DegreesFromRadians(std::hypot(1 / shank_mm, 1 / thigh_mm));
  rows.push_back({kAnkleAndHipPlacement, "normal", placement.first, "mm", sensitivity, placement.second, false});
  rows.push_back({kAnkleAndHipTissue, "normal", o.soft_tissue_mm, "mm", sensitivity, kTissueReference, false});
}

Budget KneeAngleBudget(const Misalignment& m, double replacement_sd_mm, const BudgetOptions& o) {
  std::vector<double> shank, thigh;
  for (std::size_t i = 0; i < m.human.knee.size(); ++i) {
    shank.push_back((m.human.knee[i] - m.human.ankle[i]).norm());
    thigh.push_back((m.human.hip[i] - m.human.knee[i]).norm());
  }
  Budget budget{"knee_angle", "deg", Mean(m.human.knee_deg), -180, {}};
  const Sensitivities s = OfKneeAngle(Mean(shank), Mean(thigh));
  std::optional<double> slope;
  if (!m.human.slope.empty()) slope = RootMeanSquare(Norms(m.human.slope));
  AddSources(s, OfSkin(slope, s.constant, o), Detection(RootMeanSquare(m.human.knee_sigma_mm), "mm", s.noise),
             {replacement_sd_mm, kReplacement}, o.axes.human_mm, o, budget.rows);
  AddAnkleAndHip(Mean(shank), Mean(thigh), {replacement_sd_mm, kReplacement}, o, budget.rows);
  return budget;
}

Budget KneeAngleBudget(const gait::LegFitResult& leg, const RecordingBudgetOptions& o) {
  const motion::LegMotion& motion = leg.motion;
  std::vector<double> knee_deg, sigma_deg;
  for (const motion::LegSample& sample : motion.samples)
    if (!std::isnan(sample.knee_sigma_deg)) {
      knee_deg.push_back(sample.knee_deg);
      sigma_deg.push_back(sample.knee_sigma_deg);
    }
  Budget budget{"knee_angle", "deg", Mean(knee_deg), -180, {}};
  const double shank_mm = MedianLength(motion, &motion::LegSample::ak),
               thigh_mm = MedianLength(motion, &motion::LegSample::kh);
  const std::pair<double, const char*> placement{o.placement_mm, "assumed; --placement-sd"};
  const Sensitivities s = OfKneeAngle(shank_mm, thigh_mm);
  std::optional<double> slope;
  for (const gait::MarkerReport& marker : leg.markers)
    if (marker.name == leg.leg_markers.knee && marker.parallax_per_depth > 0) slope = marker.parallax_per_depth;
  AddSources(s, OfSkin(slope, s.constant, o), Detection(RootMeanSquare(sigma_deg), "deg", 1), placement, {}, o,
             budget.rows);
  AddAnkleAndHip(shank_mm, thigh_mm, placement, o, budget.rows);
  return budget;
}

// Of the angle less that of quiet standing, which is off by the same misplacement.
Budget NeutralKneeBudget(const gait::LegFitResult& leg, const RecordingBudgetOptions& o) {
  const motion::LegMotion& motion = leg.motion;
  Budget budget = KneeAngleBudget(leg, o);
  budget.quantity = "knee_neutral_angle";
  budget.value -= motion.neutral->knee_deg;
  std::erase_if(budget.rows,
                [](const BudgetRow& row) { return row.source == kPlacement || row.source == kAnkleAndHipPlacement; });
  budget.rows.push_back({"pose of quiet standing", "normal", motion.neutral->knee_sigma_deg, "deg", 1,
                         "sway of the standing person, --neutral", true});
  return budget;
}

// Of the rises whose time is known.
std::optional<Budget> RiseBudget(const gait::LegFitResult& leg, const RecordingBudgetOptions& o) {
  std::vector<double> rise_s, fit_s;
  for (const gait::SitToStand& rise : gait::MeasureSitToStands(leg, {}))
    if (rise.repetition > 0 && std::isfinite(rise.rise_s.value)) {
      rise_s.push_back(rise.rise_s.value);
      if (std::isfinite(rise.rise_s.sd)) fit_s.push_back(rise.rise_s.sd);
    }
  if (rise_s.empty()) return std::nullopt;
  const double mean = 1 / std::sqrt(static_cast<double>(rise_s.size()));
  Budget budget{"rise", "s", Mean(rise_s), 0, {}};
  if (!fit_s.empty())
    budget.rows.push_back(
        {"event times as fitted", "normal", RootMeanSquare(fit_s), "s", mean, "covariance of the leg fit", true});
  budget.rows.push_back({"event times as defined", "normal", o.event_s, "s", std::numbers::sqrt2 * mean,
                         "assumed, of onset and of standing; --event-sd", true});
  if (rise_s.size() > 1)
    budget.rows.push_back(
        {kOwnVariation, "t", StandardDeviation(rise_s), "s", mean, "repetitions of this recording", true});
  return budget;
}

double Square(const Budget& budget, bool markers_alone) {
  double square = 0;
  for (const BudgetRow& row : budget.rows)
    if (row.is_of_markers || !markers_alone) square += row.Contribution() * row.Contribution();
  return square;
}

// Of the length of a vector in the plane whose coordinates have this deviation: from the length that is seen to be so
// long by chance in 2.5 %, to the one that is seen to be so short (Rice's distribution).
Interval LengthInterval(double length, double deviation) {
  using Distribution = boost::math::non_central_chi_squared;
  constexpr double kTail = 0.025;
  const double square = std::max(1e-6, std::pow(length / deviation, 2));
  const auto seen_so = [&](double probability) {
    if (1 - std::exp(-square / 2) <= probability) return 0.0;  // none is so seldom so short
    return deviation * std::sqrt(Distribution::find_non_centrality(2, square, probability));
  };
  return {seen_so(1 - kTail), std::max(seen_so(kTail), kNormal95 * deviation)};
}

Interval About(const Budget& budget, double deviation, double axis_deviation, double skin_mm) {
  constexpr double kFar = 8;  // deviations from which on a length errs as a coordinate does
  if (budget.size && budget.size->offset_mm < kFar * axis_deviation) {
    const double rest_square = budget.value * budget.value - std::pow(budget.size->offset_mm, 2);
    const Interval offset = LengthInterval(budget.size->offset_mm, axis_deviation);
    return {std::hypot(offset.low, std::sqrt(std::max(0.0, rest_square - skin_mm * skin_mm))),
            std::sqrt(std::max(0.0, offset.high * offset.high + rest_square))};
  }
  return {std::max(budget.least, budget.value - kNormal95 * deviation), budget.value + kNormal95 * deviation};
}

}  // namespace

double Budget::MarkerDeviation() const {
  return std::sqrt(Square(*this, true));
}
double Budget::Deviation() const {
  return std::sqrt(Square(*this, false));
}
Interval Budget::MarkerInterval() const {
  return About(*this, MarkerDeviation(), size ? size->marker_sd_mm : 0, 0);
}
Interval Budget::AnatomicalInterval() const {
  return About(*this, Deviation(), size ? size->sd_mm : 0, size ? size->skin_mm : 0);
}

double Budget::SharePercent(const BudgetRow& row) const {
  const double square = Square(*this, false);
  return square > 0 ? 100 * row.Contribution() * row.Contribution() / square : 0;
}

std::vector<Budget> BudgetsOf(const Misalignment& m, double replacement_sd_mm, const ComparisonBudgetOptions& o) {
  std::vector<Budget> budgets;
  if (m.joint) {
    const JointMisalignment& joint = *m.joint;
    const double marker_mm = RootMeanSquare(m.exo.knee_sigma_mm);
    const auto add = [&](const char* name, double value, double least, const Sensitivities& s, const auto& direction,
                         Interval JointMisalignment::Intervals::*interval) {
      Budget budget{name, "mm", value, least, {}};
      AddSources(s, OfJoint(m, direction, s.constant, o),
                 Detection(marker_mm, "mm", std::sqrt(kMarkersOfAJoint) * s.noise), {replacement_sd_mm, kReplacement},
                 o.axes.exo_mm, o, budget.rows);
      AddPlane(m, budget.rows);
      AddRebuilding(m.exo, s.constant, budget.rows);
      if (joint.intervals) AddOwnVariation(((*joint.intervals).*interval).Deviation(), "mm", budget.rows);
      budgets.push_back(std::move(budget));
    };
    using Intervals = JointMisalignment::Intervals;
    const double duration_s = m.exo.duration_s;
    add(
        "joint_rms", joint.rms_mm, 0, OfRms(joint, duration_s),
        [&](std::size_t i) { return Vector2d(joint.shank_mm[i] / std::max(joint.rms_mm, 1e-9)); }, &Intervals::rms_mm);
    add(
        "joint_offset_x", joint.mean_mm.x(), -kInfinity, OfOffset(joint, 0, duration_s),
        [](std::size_t) { return Vector2d(Vector2d::UnitX()); }, &Intervals::mean_x_mm);
    add(
        "joint_offset_y", joint.mean_mm.y(), -kInfinity, OfOffset(joint, 1, duration_s),
        [](std::size_t) { return Vector2d(Vector2d::UnitY()); }, &Intervals::mean_y_mm);
    budgets.push_back(JointFrameBudget(m, replacement_sd_mm, o));
    const auto worse = [&](double (Budget::*deviation)() const) {
      return std::max((budgets[1].*deviation)(), (budgets[2].*deviation)());
    };
    // A single frame's skin, less what is alike in all frames of the rise, along both axes.
    const double slide_square = o.axes.exo_mm ? 0 : std::pow(o.FrameTissueMm(), 2) - std::pow(o.soft_tissue_mm, 2);
    budgets[0].size = {joint.mean_mm.norm(), worse(&Budget::MarkerDeviation), worse(&Budget::Deviation),
                       std::sqrt(2 * std::max(0.0, slide_square))};
    budgets[3].size = {budgets[3].value, budgets[3].MarkerDeviation(), budgets[3].Deviation()};
  }
  budgets.push_back(KneeAngleBudget(m, replacement_sd_mm, o));
  return budgets;
}

std::vector<Budget> BudgetsOf(const gait::LegFitResult& leg, const RecordingBudgetOptions& o) {
  if (leg.motion.unit != motion::LengthUnit::kMm) return {};
  std::vector<Budget> budgets = {KneeAngleBudget(leg, o)};
  if (leg.motion.neutral) budgets.push_back(NeutralKneeBudget(leg, o));
  if (auto rise = RiseBudget(leg, o)) budgets.push_back(*std::move(rise));
  return budgets;
}

double JointDepthDeviationMm(const std::optional<gait::MarkerDepth>& depth, const BudgetOptions& o) {
  return o.depth_mm.value_or(depth ? depth->sd_mm.value_or(kSkinDepth_mm) : kJointDepth_mm);
}

Vector2d ParallaxDeviationMm(const Misalignment& m, const BudgetOptions& o) {
  Vector2d deviation_mm;
  for (const int axis : {0, 1}) {
    const Parallax parallax = OfJoint(
        m, [axis](std::size_t) { return Vector2d(Vector2d::Unit(axis)); }, 1, o);
    deviation_mm[axis] = std::abs(parallax.size_mm * parallax.sensitivity);
  }
  return deviation_mm;
}

double PlaceDeviation(const std::vector<Budget>& budgets) {
  double most_mm = -1;
  for (const Budget& budget : budgets)
    if (budget.quantity.starts_with("joint_offset")) most_mm = LargerOrNaN(most_mm, budget.Deviation());
  return most_mm < 0 ? kNaN : most_mm;
}

std::string QuantityName(const std::string& quantity) {
  constexpr std::pair<const char*, const char*> kNames[] = {
      {"joint_rms", "joint misalignment, RMS"},
      {"joint_offset_x", "joint in front of the knee"},
      {"joint_offset_y", "joint above the knee"},
      {"joint_frame", "joint misalignment, one frame"},
      {"knee_angle", "knee angle, one frame"},
      {"knee_neutral_angle", "knee angle from quiet standing, one frame"},
      {"rise", "mean time of a rise"}};
  for (const auto& [key, name] : kNames)
    if (quantity == key) return name;
  return quantity;
}

namespace {

// What a person who records can do about a source; empty: nothing.
std::string WayOut(const std::string& source, bool has_axis, bool is_of_two_trials) {
  if (source == kSoftTissue && has_axis)
    return "no marker shows what skin does as a whole; more markers, or plates on bone, narrow it";
  if (source == kSoftTissue || source == kFrameTissue)
    return "two or more markers on shank and thigh, and the axis that lake axis finds from them, narrow it";
  if (source == kAnkleAndHipTissue)
    return "two or more markers on shank and thigh show the turn without ankle and hip (lake axis)";
  if (source == kAnkleAndHipPlacement)
    return "find malleolus and greater trochanter by touch, always by the same examiner; --placement-sd or "
           "--replacement-sd says how well that is repeated";
  if (source == kAxis) return "more markers on shank and thigh, or a larger movement, narrow it";
  if (source == kPlacement && is_of_two_trials) return "leave the same markers on between the trials";
  if (source == kRebuilding) return "more repetitions without exoskeleton, or a further technical marker, narrow it";
  if (source == kOwnVariation) return "record more repetitions";
  if (source == kParallax && is_of_two_trials)
    return "measure how far the joint marker stands proud of the knee marker, towards the camera: --depth "
           "exo_knee=MM±SD";
  return "";
}

// Of a mean over repetitions: what more of them do where they are not among the sources that count.
std::string AboutRepetitions(const Budget& budget, double least_percent) {
  const bool is_mean =
      budget.quantity == "rise" || budget.quantity == "joint_rms" || budget.quantity.starts_with("joint_offset");
  if (!is_mean) return "";
  const auto own = std::ranges::find(budget.rows, kOwnVariation, &BudgetRow::source);
  if (own == budget.rows.end()) return "; one repetition does not show how far they differ: record more repetitions";
  if (budget.SharePercent(*own) >= least_percent) return "";
  return fmt::format(
      "; the scatter of the repetitions is less than {:.0f} % of it: more repetitions would not narrow it",
      least_percent);
}

}  // namespace

std::string WhatNarrows(const Budget& budget) {
  constexpr double kLeast_percent = 1;
  std::vector<BudgetRow> rows = budget.rows;
  std::ranges::sort(rows, std::ranges::greater(), &BudgetRow::Contribution);
  if (rows.empty() || rows.front().Contribution() == 0) return "No source of uncertainty is known.";
  const bool has_axis = std::ranges::find(rows, kAxis, &BudgetRow::source) != rows.end();
  std::string text =
      fmt::format("{:.0f} % of the variance comes from {}", budget.SharePercent(rows.front()), rows.front().source);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string way_out = WayOut(rows[i].source, has_axis, budget.quantity.starts_with("joint"));
    if (way_out.empty() || budget.SharePercent(rows[i]) < kLeast_percent) continue;
    if (i > 0) text += fmt::format("; {:.0f} % from {}", budget.SharePercent(rows[i]), rows[i].source);
    text += ": " + way_out;
  }
  return text + AboutRepetitions(budget, kLeast_percent) + ".";
}

void WriteUncertaintyBudgetCsv(const std::filesystem::path& path, const std::vector<Budget>& budgets) {
  CsvWriter csv({"quantity", "source", "distribution", "size", "unit", "sensitivity", "contribution", "share_percent",
                 "reference"});
  for (const Budget& budget : budgets)
    for (const BudgetRow& row : budget.rows)
      csv.AddRow(budget.quantity + "_" + budget.unit, row.source, row.distribution, row.size, row.unit, row.sensitivity,
                 row.Contribution(), budget.SharePercent(row), row.reference);
  csv.Write(path);
}

Json BudgetsJson(const std::vector<Budget>& budgets) {
  Json json = Json::object();
  for (const Budget& budget : budgets) {
    const Interval markers = budget.MarkerInterval(), anatomy = budget.AnatomicalInterval();
    json[budget.quantity + "_" + budget.unit] = {{"value", budget.value},
                                                 {"marker_sd", budget.MarkerDeviation()},
                                                 {"marker_interval", {markers.low, markers.high}},
                                                 {"anatomical_sd", budget.Deviation()},
                                                 {"anatomical_interval", {anatomy.low, anatomy.high}},
                                                 {"narrower", WhatNarrows(budget)}};
  }
  return json;
}

void Describe(BudgetOptions& o, OptionList& options) {
  options
      .Add("soft-tissue", o.soft_tissue_mm,
           "Standard deviation, per axis, of the knee's marker against the joint beneath it; 0 for renderings")
      .Unit("mm")
      .Between(kPlausibleMarkerDeviation.low, kPlausibleMarkerDeviation.high);
  options.Add("depth-sd", o.depth_mm, "Standard deviation of a marker's distance from the plane against another's")
      .Unit("mm")
      .NotNegative()
      .Otherwise(
          fmt::format("{:g}; of the joint that of its --depth, {:g} without one", kSkinDepth_mm, kJointDepth_mm));
  options.Add("view-slope", o.view_slope, "How far the joint stands from the camera's axis, over its distance")
      .NotNegative()
      .Otherwise(fmt::format("as the trial's camera saw it, else {:g}", kViewSlope));
  options.Add("scale-sd", o.scale_percent, "Standard deviation of the plane's scale").Unit("percent").NotNegative();
  options.Add("event-sd", o.event_s, "Standard deviation of onset and standing").Unit("s").NotNegative();
}

void Describe(ComparisonBudgetOptions& o, OptionList& options) {
  Describe(static_cast<BudgetOptions&>(o), options);
  options
      .Add("frame-tissue", o.frame_tissue_mm,
           "Standard deviation, per axis, of the knee's marker against the joint beneath it in a single frame; of no "
           "effect where the knee is an axis")
      .Unit("mm")
      .Between(kPlausibleMarkerDeviation.low, kPlausibleMarkerDeviation.high)
      .Otherwise("twice --soft-tissue");
}

void Describe(RecordingBudgetOptions& o, OptionList& options) {
  Describe(static_cast<BudgetOptions&>(o), options);
  options
      .Add("placement-sd", o.placement_mm,
           "Standard deviation, per axis, of a marker's place on the skin between days or examiners")
      .Unit("mm")
      .Between(kPlausibleMarkerDeviation.low, kPlausibleMarkerDeviation.high);
}

}  // namespace lake::compare
