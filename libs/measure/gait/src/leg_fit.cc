#include "lake/gait/leg_fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

#include "detections.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/progress.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/gait/butterworth.h"
#include "lake/gait/learnt_knee.h"
#include "lake/gait/persons_leg.h"
#include "lake/gait/plausibility.h"
#include "leg_curves.h"
#include "leg_space.h"
#include "rebuilt_knee.h"
#include "sizes.h"

namespace lake::gait {
namespace {

void CheckRecording(const motion::MarkerRecording& recording, const LegFitOptions& options) {
  if (recording.Frames() < kLeastFrames)
    throw Fail("leg fit: a recording of {} frames is too short", recording.Frames());
  for (std::size_t i = 0; i < recording.Frames(); ++i)
    if (!std::isfinite(recording.time_s[i]) || (i > 0 && recording.time_s[i] <= recording.time_s[i - 1]))
      throw Fail("leg fit: frame {}: time stamp {} does not follow the one before", recording.frame[i],
                 recording.time_s[i]);
  if (const double step_s = MedianInterval(recording.time_s); step_s > options.longest_step_s)
    throw Fail(
        "leg fit: the frames are {} s apart (median), at most {} s show how a leg moves; times are in seconds: "
        "are these in ms?",
        SignificantText(step_s, 3), SignificantText(options.longest_step_s, 3));
  if (std::abs(options.up.norm() - 1) > 1e-6) throw Fail("leg fit: the vertical must be a unit vector");
  if (options.cutoff_hz && options.filter == LegFilter::kNone)
    throw UsageError("--cutoff: --filter none has no cutoff");
  if (options.cutoff_hz)
    CheckCutoff(*options.cutoff_hz,
                static_cast<double>(recording.Frames() - 1) / (recording.time_s.back() - recording.time_s.front()));
}

// Of movements that nothing was recorded of.
void WarnOfPauses(const motion::MarkerRecording& recording, const LegFitOptions& options,
                  std::vector<std::string>& warnings) {
  for (std::size_t i = 1; i < recording.Frames(); ++i)
    if (const double pause_s = recording.time_s[i] - recording.time_s[i - 1]; pause_s > options.longest_pause_s)
      warnings.push_back(
          fmt::format("nothing is recorded for {} s after frame {} ({:.3f} s): what moved meanwhile is not known",
                      SignificantText(pause_s, 3), recording.frame[i - 1], recording.time_s[i - 1]));
}

// Says to which decimal the times of an even recording were rounded, where that moves them by a tenth of a frame or
// more; else nothing. Times that are uneven by themselves, as where frames are missing, do not lie so near a line.
std::optional<std::string> RoundedTimes(const motion::MarkerRecording& recording) {
  const std::vector<double>& time_s = recording.time_s;
  const auto frame = [&](std::size_t i) { return static_cast<double>(recording.frame[i] - recording.frame.front()); };
  const double step_s = (time_s.back() - time_s.front()) / frame(recording.Frames() - 1);
  for (const double unit_s : {1.0, 0.1, 0.01, 0.001}) {
    if (unit_s < step_s / 5) break;
    const double units = step_s / unit_s;
    bool is_rounded = std::abs(units - std::round(units)) > 1e-3;
    for (std::size_t i = 0; is_rounded && i < recording.Frames(); ++i)
      is_rounded = std::abs(time_s[i] / unit_s - std::round(time_s[i] / unit_s)) < 1e-6 &&
                   std::abs(time_s[i] - time_s.front() - step_s * frame(i)) < 1.01 * unit_s;
    if (is_rounded)
      return fmt::format("the times are rounded to {:g} s, and frames are {} s apart", unit_s,
                         SignificantText(step_s, 3));
  }
  return {};
}

// Of times that are not in seconds, as nobody records legs so fast; else nothing.
std::optional<std::string> HastyTimes(const motion::MarkerRecording& recording) {
  constexpr double kShortest_s = 1e-3;
  const double step_s = MedianInterval(recording.time_s);
  if (step_s >= kShortest_s) return {};
  return fmt::format("the times say that frames are {} s apart, {} s in all", SignificantText(step_s, 3),
                     SignificantText(recording.time_s.back() - recording.time_s.front(), 3));
}

// An exchange of names makes the one length vary and leaves the other alone.
void WarnOfLengths(const std::vector<SegmentReport>& segments, const LegFitOptions& options,
                   std::vector<std::string>& warnings) {
  const LegMarkers& names = options.markers;
  const bool has_trunk = segments.size() > 2;
  for (const SegmentReport& segment : segments) {
    const bool is_shank = segment.name == "ak";
    if (segment.name == "hw" || segment.variation <= options.most_usual_variation * segment.length) continue;
    warnings.push_back(fmt::format(
        "the {}'s length varies by {:.0f} % (SD), skin moves by {:.0f} % at most: are {} and {} exchanged? Does the "
        "person come nearer or go away? Are the picture's width and height in the same scale, and camera and plane "
        "those of this recording?",
        is_shank ? "shank" : "thigh", 100 * segment.variation / segment.length, 100 * options.most_usual_variation,
        !is_shank && !has_trunk ? names.ankle
        : is_shank              ? names.knee
                                : names.hip,
        !is_shank && !has_trunk ? names.knee
        : is_shank              ? names.hip
                                : names.waist));
  }
}

std::string Names(const motion::MarkerRecording& recording) {
  std::string names;
  for (const motion::MarkerTrack& marker : recording.markers) names += (names.empty() ? "" : ", ") + marker.name;
  return names.empty() ? "none" : names;
}

// As recorded, the median; 0 where ankle and knee are never seen together.
double ShankOf(const motion::MarkerRecording& recording, const LegMarkers& names) {
  const motion::MarkerTrack *ankle = recording.Find(names.ankle), *knee = recording.Find(names.knee);
  std::vector<double> lengths;
  for (std::size_t i = 0; ankle && knee && i < recording.Frames(); ++i)
    if (ankle->samples[i].status == motion::SampleStatus::kDetected &&
        knee->samples[i].status == motion::SampleStatus::kDetected)
      lengths.push_back((knee->samples[i].position - ankle->samples[i].position).norm());
  return lengths.empty() ? 0 : Median(std::move(lengths));
}

std::array<Detections, kLegMarkers> CollectLeg(const motion::MarkerRecording& recording, const LegView& view,
                                               const LegMarkers& names, double skin) {
  std::array<Detections, kLegMarkers> leg;
  for (const motion::LegMarker m : {kAnkle, kKnee, kHip, kWaist}) {
    const std::string name = names.Of(m);
    const motion::MarkerTrack* track = recording.Find(name);
    if (track) {
      leg[m] = CollectDetections(recording, *track, view, skin);
      MistrustIsolated(leg[m], recording.time_s);
    } else if (m != kWaist)
      throw Fail("leg fit: no marker '{}' in the recording (it has: {}); name the leg's markers with --map", name,
                 Names(recording));
    else
      leg[m].name = name;
  }
  return leg;
}

LegPath MeasuredPath(const motion::MarkerRecording& recording, const std::array<Detections, kLegMarkers>& leg,
                     const LegView& view, const Eigen::Matrix2d& leg_from_plane, motion::Facing facing,
                     const LegFitOptions& options) {
  LegPath path;
  path.unit = PlaneUnit(view);
  path.facing = facing;
  path.is_facing_given = options.facing.has_value();
  path.frame = recording.frame;
  for (std::size_t m = 0; m < leg.size(); ++m) {
    const Detections& d = leg[m];
    path.name[m] = d.name;
    path.marker[m].assign(recording.Frames(), Eigen::Vector3d::Constant(motion::LegSample::kUnknown));
    for (std::size_t i = 0; i < d.trusted.size(); ++i)
      if (d.trusted[i]) path.marker[m][i] << leg_from_plane * d.in_plane[i], d.lateral.empty() ? 0 : d.lateral[i];
  }
  return path;
}

FacingFound FindFacingOf(const std::array<Detections, kLegMarkers>& leg) {
  std::vector<LegPoints> frames;
  for (std::size_t i = 0; i < leg[kAnkle].trusted.size(); ++i)
    if (leg[kAnkle].trusted[i] && leg[kKnee].trusted[i] && leg[kHip].trusted[i])
      frames.push_back({leg[kAnkle].in_plane[i], leg[kKnee].in_plane[i], leg[kHip].in_plane[i], std::nullopt});
  return FindFacing(frames);
}

Eigen::Matrix2d PlaneFromLegAxes(motion::Facing facing, const Eigen::Vector2d& up) {
  Eigen::Matrix2d axes;
  axes << PlaneFromLeg(Eigen::Vector2d::UnitX(), facing, up), PlaneFromLeg(Eigen::Vector2d::UnitY(), facing, up);
  return axes;
}

// Of the detections that are used, about the curves, in their standard deviations.
double ResidualRms(const std::array<Detections, kLegMarkers>& leg, const LegCurves& curves) {
  std::vector<double> squares;
  for (std::size_t m = 0; m < static_cast<std::size_t>(curves.markers); ++m)
    for (std::size_t i = 0; i < leg[m].trusted.size(); ++i)
      if (leg[m].trusted[i] && leg[m].seen[i])
        squares.push_back((leg[m].in_plane[i] - curves.marker[m].InPlane(i)).squaredNorm() / 2 /
                          std::pow(curves.marker[m].scatter[i] * leg[m].plane_sigma[i], 2));
  return std::sqrt(Mean(squares));
}

}  // namespace

void Describe(LegFitOptions& o, OptionList& options) {
  options.AddChoice(
      "filter", o.filter,
      OptionList::Choices<LegFilter>{
          {"spline", LegFilter::kSpline}, {"butterworth", LegFilter::kButterworth}, {"none", LegFilter::kNone}},
      "Filter of positions and angles");
  options.Add("cutoff", o.cutoff_hz, "Cutoff frequency of the filter")
      .Unit("Hz")
      .Positive()
      .Otherwise("found from the data (spline), 6 (butterworth)");
  Describe(o.movement, options);
  Describe(o.technical, options);
  DescribeKneeFrom(o.knee_trial, options);
}

void DescribeFacing(LegFitOptions& o, OptionList& options) {
  using motion::Facing;
  options
      .AddChoice("facing", o.facing, OptionList::Choices<Facing>{{"left", Facing::kLeft}, {"right", Facing::kRight}},
                 "Direction in which the subject faces, in the plane")
      .Otherwise("found from the movement");
}

namespace {

void AddToSigmas(const UnusualLength& unusual, LegFitResult& result) {
  result.warnings.push_back(unusual.warning);
  for (std::size_t i = 0; i < result.motion.samples.size(); ++i) {
    double& sigma_deg = result.motion.samples[i].knee_sigma_deg;
    sigma_deg = std::hypot(sigma_deg, unusual.angle_sigma_deg[i]);
  }
}

LegFitResult FitOnce(const motion::MarkerRecording& recording, const LegView& view, const LegFitOptions& options,
                     const LateralPlaces& lateral) {
  Progress progress("leg fit", "steps", 3, options.quiet);
  LegFitResult result;
  result.up = options.up;
  result.leg_markers = options.markers;
  const double shank = ShankOf(recording, options.markers),
               skin = options.skin_jump * (shank == 0 && options.knee_from ? options.knee_from->shank_mm : shank);
  std::array<Detections, kLegMarkers> leg = CollectLeg(recording, view, options.markers, skin);
  if (!lateral.empty()) SetLateral(lateral, leg);
  if (options.knee_from)
    result.rebuilt_knee = RebuildKnee(*options.knee_from, recording, view, lateral, options, leg, result.warnings);
  const FacingFound found = FindFacingOf(leg);
  const motion::Facing facing = options.facing.value_or(found.facing);
  if (!options.facing && !found.IsCertain())
    result.warnings.push_back(
        fmt::format("the knee bends by {:.0f}° at most: which way the subject faces is a guess; give it with {}",
                    found.largest_flexion_deg, options.facing_option));

  WarnOfPauses(recording, options, result.warnings);
  CheckIsSeen(leg);
  const Eigen::Matrix2d leg_from_plane = PlaneFromLegAxes(facing, options.up).transpose();
  const LegPath measured = MeasuredPath(recording, leg, view, leg_from_plane, facing, options);
  for (std::string& warning : CheckPersonsLeg(measured, {}, options)) result.warnings.push_back(std::move(warning));
  progress.Advance();
  const int markers = FramesTogether(leg[kHip], leg[kWaist]) >= kLeastFrames ? kLegMarkers : kLegMarkers - 1;
  LegMarkerCurves smooth = SmoothLeg(recording.time_s, markers, view, options, leg);
  progress.Advance();
  result.summary = {.known_sigmas = options.known_sigmas,
                    .lasting_share = options.lasting_share,
                    .learnt_lasting_share = smooth.lasting_share,
                    .noise_memory_s = smooth.noise_memory_s,
                    .cutoff_hz = options.cutoff_hz.value_or(smooth.cutoff_hz)};
  const LegCurves curves =
      MakeLegCurves(recording.time_s, std::move(smooth), markers, leg_from_plane, leg, options.facing.has_value());
  if (!lateral.empty()) result.lateral = ReportLateral(leg);
  FillResult(recording, leg, curves, view, facing, skin, options, result);
  for (const UnusualLength& unusual : UnusualLengths(measured, options)) AddToSigmas(unusual, result);
  result.summary.residual_rms = ResidualRms(leg, curves);
  WarnOfLengths(result.segments, options, result.warnings);
  progress.Advance();
  return result;
}

bool IsOfLeg(const std::string& marker, const LegMarkers& names) {
  return marker == names.ankle || marker == names.knee || marker == names.hip || marker == names.waist;
}

// Without the detections that the implausible values come from.
motion::MarkerRecording Without(const std::vector<Implausible>& implausible, motion::MarkerRecording recording) {
  for (motion::MarkerTrack& marker : recording.markers)
    for (const Implausible& found : implausible)
      for (std::size_t i = 0; std::ranges::count(found.markers, marker.name) > 0 && i < found.at.size(); ++i)
        if (found.at[i]) marker.samples[i] = {};
  return recording;
}

// All that no person does.
std::vector<Implausible> FindAllImplausible(const LegFitResult& result, const LegMarkers& names,
                                            const PlausibilityLimits& limits) {
  std::vector<Implausible> found = FindImplausible(result.motion, result.trajectory, names, limits);
  std::ranges::move(FindImplausibleTrunk(result.motion, names, limits), std::back_inserter(found));
  return found;
}

// What is implausible where nothing was left to leave out is not known. The leg does not depend on the waist.
void Blank(const std::vector<Implausible>& implausible, const LegMarkers& names, LegFitResult& result) {
  for (const Implausible& found : implausible) {
    result.warnings.push_back(
        fmt::format("frames {}: {}: no angle is given there", FramesOf(result.motion.frame, found.at), found.what));
    for (std::size_t i = 0; i < found.at.size(); ++i) {
      motion::LegSample& sample = result.motion.samples[i];
      if (!found.at[i]) continue;
      if (found.markers == std::vector{names.waist}) {
        sample.hw = motion::LegSample().hw;
        sample.trunk_deg = motion::LegSample::kUnknown;
      } else
        sample = {};
    }
    result.trajectory = Without({found}, std::move(result.trajectory));
  }
}

std::ptrdiff_t DetectionsOf(const motion::MarkerRecording& recording, const std::string& marker) {
  return std::ranges::count_if(recording.Find(marker)->samples, [](const motion::MarkerSample& sample) {
    return sample.status == motion::SampleStatus::kDetected;
  });
}

void WarnOfOutliers(const motion::MarkerRecording& recording, LegFitResult& result) {
  for (const MarkerReport& marker : result.markers) {
    if (marker.outliers == 0) continue;
    std::vector<char> at(result.motion.frame.size(), 0);
    for (const OutlierReport& outlier : result.outliers)
      if (outlier.marker == marker.name)
        at[static_cast<std::size_t>(std::ranges::lower_bound(result.motion.frame, outlier.frame) -
                                    result.motion.frame.begin())] = 1;
    result.warnings.push_back(fmt::format(
        "{} of the {} detections of marker '{}' are left out, as no leg moves so (frames {})", marker.outliers,
        DetectionsOf(recording, marker.name), marker.name, FramesOf(result.motion.frame, at)));
  }
}

// Whether the rest is the greater part of the recording.
void CheckRemains(const motion::MarkerRecording& recording, const LegFitResult& result, const std::string& ways_out,
                  const LegFitOptions& options) {
  constexpr double kLeast = 0.5;
  const LegMarkers& names = options.markers;
  std::ptrdiff_t seen = 0;
  for (std::size_t i = 0; i < recording.Frames(); ++i)
    seen += std::ranges::all_of(std::array{&names.ankle, &names.knee, &names.hip}, [&](const std::string* name) {
      return recording.Find(*name)->samples[i].status == motion::SampleStatus::kDetected;
    });
  const auto known =
      std::ranges::count_if(result.motion.samples, [](const auto& sample) { return std::isfinite(sample.knee_deg); });
  const std::string said = result.warnings.empty() ? "" : ": " + result.warnings.back();
  if (static_cast<double>(known) < kLeast * static_cast<double>(seen))
    throw Fail(
        "leg fit: in {} of the {} frames that show ankle, knee and hip the markers are where a person's leg can be{}; "
        "look at the other frames, {}",
        known, seen, said, ways_out);
  for (const MarkerReport& marker : result.markers) {
    const std::ptrdiff_t detections = DetectionsOf(recording, marker.name);
    if (IsOfLeg(marker.name, names) && marker.outliers > kLeast * static_cast<double>(detections))
      throw Fail(
          "leg fit: {} of the {} detections of marker '{}' fit no leg's movement, so it is not known which are the "
          "leg's; look at these frames, {}",
          marker.outliers, detections, marker.name, ways_out);
  }
}

}  // namespace

LegFitResult FitLeg(const motion::MarkerRecording& recording, const LegView& view, const LegFitOptions& options,
                    const LateralPlaces& lateral) {
  if (options.knee_from && !recording.Find(options.markers.knee)) {  // hidden in every frame
    motion::MarkerRecording with_knee = recording;
    with_knee.markers.push_back({options.markers.knee, std::vector<motion::MarkerSample>(recording.Frames())});
    LateralPlaces with_lateral = lateral;
    if (!lateral.empty()) with_lateral[options.markers.knee].assign(recording.Frames(), kNaN);
    return FitLeg(with_knee, view, options, with_lateral);
  }
  CheckRecording(recording, options);
  const std::optional<std::string> rounded = RoundedTimes(recording);
  PlausibilityLimits limits;
  const std::optional<std::string> hasty = HastyTimes(recording);
  limits.ways_out = hasty     ? "or give the times in seconds: " + *hasty
                    : rounded ? "or give the times with more digits: " + *rounded
                              : options.ways_out;
  LegFitResult result = FitOnce(recording, view, options, lateral);
  std::vector<Implausible> implausible = FindAllImplausible(result, options.markers, limits);
  if (!implausible.empty()) {
    result = FitOnce(Without(implausible, recording), view, options, lateral);
    for (const Implausible& found : implausible)
      if (!found.markers.empty())
        result.warnings.push_back(fmt::format("frames {}: {}: '{}' left out there",
                                              FramesOf(result.motion.frame, found.at), found.what,
                                              fmt::join(found.markers, "', '")));
    Blank(FindAllImplausible(result, options.markers, limits), options.markers, result);
  }
  result.sight = SightOf(view);
  WarnOfOutliers(recording, result);
  if (hasty) result.warnings.insert(result.warnings.begin(), *hasty + ": are they in seconds?");
  if (rounded)
    result.warnings.insert(result.warnings.begin(),
                           *rounded + ": what moves fast is misplaced by that; give them with more digits");
  CheckRemains(recording, result, limits.ways_out, options);
  std::vector<motion::StsEvent> rises = result.events;
  rises.insert(rises.end(), result.without_seat.begin(), result.without_seat.end());
  CheckPersonsLeg(PathOf(result.motion), rises, options);
  return result;
}

}  // namespace lake::gait
