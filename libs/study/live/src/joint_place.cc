#include "lake/live/joint_place.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "lake/compare/joint_misalignment.h"
#include "lake/compare/registration.h"
#include "lake/core/distributions.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/gait/leg_fit.h"
#include "lake/tracking/sigma_calibration.h"

namespace lake::live {

using Eigen::Vector2d;

namespace {

RiseOffset OffsetOf(const compare::StsCurve& curve, const std::optional<compare::MarkerSight>& sight,
                    const compare::StsInterval& interval) {
  compare::RegisteredTrial one;
  one.repetitions.push_back(curve);
  const std::vector<bool> no_spikes(curve.knee.size());
  const auto joint = compare::FindJointMisalignment(one, no_spikes);
  if (!joint) throw Error("the recording does not show the leg's own knee");
  compare::Misalignment seen;
  seen.exo = curve;
  seen.exo_sight = sight;
  return {.onset_s = interval.onset_s,
          .standing_s = interval.standing_s,
          .mean_mm = joint->mean_mm,
          .noise_sd_mm = Vector2d::Constant(compare::MarkerNoiseOfMeanMm(curve)),
          .remainder_mm = joint->remainder_mm,
          .parallax_sd_mm = compare::ParallaxDeviationMm(seen, {}),
          .rebuilt_sd_mm = curve.rebuilt_sd_mm.empty() ? 0 : RootMeanSquare(curve.rebuilt_sd_mm)};
}

// "12 mm back"; empty where it does not differ from nothing.
std::string PartText(double move_mm, double half_width_mm, const char* forward, const char* back) {
  if (std::abs(move_mm) < half_width_mm || std::abs(move_mm) < 0.5) return "";
  return fmt::format("{:.0f} mm {}", std::abs(move_mm), move_mm > 0 ? forward : back);
}

std::string PlusMinus(double half_width_mm) {
  return fmt::format("(± {:.0f} mm)", std::max(1.0, std::ceil(half_width_mm)));
}

}  // namespace

FoundRises FindRiseOffsets(motion::MarkerRecording recording, const RiseFinding& finding) {
  gait::LegFitOptions fit;
  fit.known_sigmas = true;
  fit.knee_from = finding.knee_from;
  fit.lasting_share = tracking::CalibrateSigmas(finding.video, recording).lasting_share;
  const gait::LegFitResult leg = gait::FitLeg(gait::AtFrameTimes(recording, finding.shutter), finding.view, fit);
  const compare::TrialTables tables{"live", leg.trajectory, leg.motion, leg.events, leg.sight};
  compare::RegistrationOptions registration;
  registration.knee = finding.joint;
  registration.marker_at_mm = finding.marker_at_mm;
  const compare::RegisteredTrial trial = compare::RegisterTrial(tables, registration);
  const std::vector<compare::StsInterval> intervals = compare::FindStsIntervals(tables);
  FoundRises found;
  if (trial.repetitions.back().repetition != intervals.back().repetition)
    found.why_last_is_left_out = trial.warnings.back();
  for (const compare::StsCurve& curve : trial.repetitions) {
    const auto interval = std::ranges::find(intervals, curve.repetition, &compare::StsInterval::repetition);
    if (interval == intervals.end() || curve.leg_knee.empty()) continue;
    found.rises.push_back(OffsetOf(curve, trial.sight, *interval));
  }
  return found;
}

JointPlace PlaceOf(std::span<const RiseOffset> rises, const compare::RecordingBudgetOptions& budget) {
  const auto n = static_cast<double>(rises.size());
  JointPlace place;
  place.rises = static_cast<int>(rises.size());
  double rebuilt_sd_mm = 0;
  for (const RiseOffset& rise : rises) {
    place.offset_mm += rise.mean_mm / n;
    place.parallax_sd_mm += rise.parallax_sd_mm / n;
    rebuilt_sd_mm += rise.rebuilt_sd_mm / n;
  }
  for (const int axis : {0, 1}) {
    double noise = 0, spread = 0;  // variances
    for (const RiseOffset& rise : rises) {
      noise += std::pow(rise.noise_sd_mm[axis], 2) / n;
      spread += std::pow(rise.mean_mm[axis] - place.offset_mm[axis], 2);
    }
    // Rises differ by the noise at least; by what more, only those that there are can show.
    double half_width = kNormal95 * std::sqrt(noise / n);
    if (rises.size() > 1) {
      const double t = StudentQuantile(n - 1, 0.975);
      half_width = std::max(half_width, t * std::sqrt(spread / (n - 1) / n));
    }
    const double scale = budget.scale_percent / 100 * place.offset_mm[axis];
    const double skin = std::hypot(budget.placement_mm, budget.soft_tissue_mm);
    place.fixed_half_width_mm[axis] = kNormal95 * std::hypot(scale, place.parallax_sd_mm[axis], rebuilt_sd_mm);
    place.half_width_mm[axis] = std::hypot(half_width, place.fixed_half_width_mm[axis]);
    place.anatomical_half_width_mm[axis] = std::hypot(place.half_width_mm[axis], kNormal95 * skin);
  }
  return place;
}

bool JointPlace::DoRisesNarrow() const {
  Eigen::Index axis = 0;
  half_width_mm.maxCoeff(&axis);
  const double all = std::pow(half_width_mm[axis], 2), fixed = std::pow(fixed_half_width_mm[axis], 2);
  return all - fixed > fixed;
}

double LeastUncertaintyMm(const RiseOffset& at_knee_without_noise) {
  return PlaceOf({&at_knee_without_noise, 1}).UncertaintyMm();
}

std::string MoveText(const JointPlace& place, double tolerance_mm) {
  const std::string within = PlusMinus(place.UncertaintyMm());
  if (JudgeTolerance(place, tolerance_mm) == ToleranceVerdict::kWithin) return "Leave the joint where it is " + within;
  const Vector2d move_mm = -place.offset_mm;
  const std::string along = PartText(move_mm.x(), place.half_width_mm.x(), "forward", "back"),
                    up = PartText(move_mm.y(), place.half_width_mm.y(), "up", "down");
  if (!along.empty() || !up.empty())
    return fmt::format("Move the joint {}{}{} {}", along, along.empty() || up.empty() ? "" : " and ", up, within);
  if (place.DoRisesNarrow())
    return fmt::format("The joint's place is not known well enough yet {}: one more rise", within);
  const bool is_of_depth = kNormal95 * place.parallax_sd_mm.maxCoeff() > tolerance_mm;
  return fmt::format(
      "The joint's distance cannot be distinguished from {:g} mm {}{}", tolerance_mm, within,
      is_of_depth ? ": measure how far its marker stands proud of the knee's, --depth exo_knee=MM±SD" : "");
}

std::string ChangeText(const JointPlace& before, const JointPlace& now) {
  const double nearer_mm = before.DistanceMm() - now.DistanceMm();
  // Scale and parallax are the same before and after; what is left is less than both intervals together.
  const double half_width_mm = std::hypot(before.UncertaintyMm(), now.UncertaintyMm());
  if (std::abs(nearer_mm) < half_width_mm)
    return fmt::format("No measurable difference from before the last move {}{}", PlusMinus(half_width_mm),
                       now.DoRisesNarrow() ? ": one more rise" : "");
  return fmt::format("{:.0f} mm {} the knee than before the last move {}", std::abs(nearer_mm),
                     nearer_mm > 0 ? "nearer to" : "farther from", PlusMinus(half_width_mm));
}

ToleranceVerdict JudgeTolerance(const JointPlace& place, double tolerance_mm) {
  if (place.DistanceMm() + place.UncertaintyMm() <= tolerance_mm) return ToleranceVerdict::kWithin;
  if (place.DistanceMm() - place.UncertaintyMm() > tolerance_mm) return ToleranceVerdict::kBeyond;
  return ToleranceVerdict::kUndecided;
}

std::string ToString(ToleranceVerdict verdict) {
  constexpr std::array kNames = {"within", "beyond", "undecided"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

TrialPart PartOfTrial(const TrialPart& asked, std::span<const double> moves_s, std::span<const double> onsets_s) {
  std::optional<double> last_s;
  for (const double onset_s : onsets_s)
    if ((!asked.begin_s || onset_s >= *asked.begin_s) && (!asked.end_s || onset_s <= *asked.end_s))
      last_s = last_s ? std::max(*last_s, onset_s) : onset_s;
  TrialPart part = asked;
  if (!last_s) return part;
  const auto next = std::ranges::upper_bound(moves_s, *last_s);
  if (next != moves_s.begin()) part.begin_s = std::max(asked.begin_s.value_or(0), *std::prev(next));
  if (next != moves_s.end()) part.end_s = asked.end_s ? std::min(*asked.end_s, *next) : *next;
  return part;
}

}  // namespace lake::live
