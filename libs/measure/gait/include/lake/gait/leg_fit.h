// The leg fit: from marker positions with gaps, noise and outliers to the leg's vectors and angles with standard
// deviations.
//
// Each marker is smoothed by the path model of lake::dynamics, whose parameters are learnt from the recording; a hidden
// marker keeps the lengths of its segments (README of this room).
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/gait/leg_angles.h"
#include "lake/gait/leg_view.h"
#include "lake/gait/movement.h"
#include "lake/gait/sts_events.h"
#include "lake/motion/leg_motion.h"
#include "lake/motion/marker_recording.h"

namespace lake::gait {

enum class LegFilter {
  kSpline,       // the leg fit itself
  kButterworth,  // marker positions (gaps from the fit) through ZeroPhaseButterworth
  kNone,         // each frame by itself (gaps from the fit)
};

// Further markers on the skin of the leg's segments: shank and thigh.
using TechnicalMarkers = std::map<std::string, std::vector<std::string>>;
struct LearntKnee;  // learnt_knee.h

struct LegFitOptions {
  LegFilter filter = LegFilter::kSpline;
  std::optional<double> cutoff_hz;  // spline: found from the data; Butterworth: 6 Hz
  LegMarkers markers;
  std::optional<motion::Facing> facing;           // found from the data
  Eigen::Vector2d up = Eigen::Vector2d::UnitY();  // the vertical, in the plane frame
  double skin_jump = 0.01;                        // of |AK|: so far skin may jump on the bone between two frames
  // Of |AK| and |KH|, 5 % to 95 % quantile over the median. Skin makes 0.14, points without markers 0.4: up to the
  // usual range nothing is said, up to the most the angle's sigma holds what the lengths show, beyond it is no limb.
  double usual_length_range = 0.30, most_length_range = 0.45;
  double most_usual_variation =
      0.06;                      // SD of |AK| and |KH| over their length, warned of beyond it; skin makes 0.05 at most
  double longest_step_s = 0.25;  // between frames, their median: from fewer no rise can be detected
  double longest_pause_s = 0.5;  // between two frames without a warning
  double most_filled_sigma = 0.04;  // of |AK|: a hidden marker less certain than this is missing (17 mm of an adult's)
  // The sigmas hold, as the tracker's: what scatters beyond them is the person's own movement. Else it may be noise.
  bool known_sigmas = false;
  // Of the sigmas' squares, at least: errors that stay alike for some frames, as a film's coding makes them.
  double lasting_share = 0;
  TechnicalMarkers technical;                       // what LearnKnee learns from
  std::optional<std::filesystem::path> knee_trial;  // --knee-from: ReadKneeFrom takes it in
  std::shared_ptr<const LearntKnee> knee_from;      // rebuilds the knee where its marker is hidden
  bool HasSplineCutoff() const { return filter == LegFilter::kSpline && cutoff_hz.has_value(); }
  MovementOptions movement;
  bool quiet = true;  // no progress

  // By what the program at work says which way is up and where the subject faces, and what can be done about frames
  // that no leg's motion explains; for messages.
  std::string vertical_option = "--up", facing_option = "--facing", names_option = "--map";
  std::string ways_out = "leave them out (lake convert --crop), or put the markers right";
  std::string said_facing;  // where `facing` is from, e.g. --forward; empty: --facing
  // What to ask where a leg is far too short or long; with the unit (m, cm) in which it would be a leg, or "".
  std::function<std::string(const std::string& unit)> unit_question = [](const std::string& unit) {
    return unit.empty() ? std::string("are its lengths in mm?")
                        : fmt::format("are its lengths in {}, not in mm?", unit);
  };
};

// All but where the subject faces, which not every program asks.
void Describe(LegFitOptions& o, OptionList& options);
void DescribeFacing(LegFitOptions& o, OptionList& options);

// A marker's record in the fit. Lengths in the recorded unit.
struct MarkerReport {
  std::string name;
  int detected = 0, filled = 0, missing = 0, outliers = 0;
  double rms = 0;    // per axis, of the detections that are no outliers
  double worst = 0;  // 2-D, among all detections
  std::int64_t worst_frame = 0;
  double noise_scale = 1;  // ≥ 1: how much larger the scatter about smooth paths is than the detections' sigmas
  double parallax_per_depth =
      0;  // mm of error per mm that the marker stands off the calibrated plane (median); 0 without one
};

struct SegmentReport {
  std::string name;         // ak, kh, hw
  double length = 0;        // mean, unit of the plane
  double length_sigma = 0;  // of that mean, from the detections' noise (not the scale's)
  double variation = 0;     // SD over time beyond the noise: skin, out-of-plane movement
};

struct OutlierReport {
  std::int64_t frame = 0;
  std::string marker;
  double residual = 0;    // recorded unit
  double deviations = 0;  // in sigmas
};

// How the markers were found to move and to err.
struct LegFitSummary {
  bool known_sigmas = false;        // as in the options
  double lasting_share = 0;         // as in the options
  double learnt_lasting_share = 0;  // of the variance of the detections' errors, with
  double noise_memory_s = 0;        // the time over which it lasts
  double cutoff_hz = 0;             // of the low-pass that the knee's smoothing amounts to
  double residual_rms = 0;          // in standard deviations of the detections' errors
};

// Of trials in three dimensions: how far the leg leaves the plane.
struct LateralReport {
  double rms_mm = 0;             // lateral movement of ankle, knee and hip
  double largest_shank_deg = 0;  // between segment and plane
  double largest_thigh_deg = 0;
};

// Where the knee's marker was hidden and technical markers replaced it.
struct RebuiltKnee {
  std::string trial;         // where it was learnt
  std::vector<char> frames;  // 0 or 1 per frame
  // Where the marker is seen: the seen place less the rebuilt one, in the segment's frame (x anterior, y up the leg),
  // mm.
  std::size_t seen_frames = 0;
  Eigen::Vector2d difference_mm = Eigen::Vector2d::Zero();  // mean
  double difference_rms_mm = 0;
  double sd_mm = 0;  // of the rebuilt places, per axis, root mean square
};

struct LegFitResult {
  motion::MarkerRecording tracks;      // as recorded, gaps filled where the fit is certain enough
  motion::MarkerRecording trajectory;  // in the plane frame, filtered as asked; unit px without a scale
  motion::MarkerRecording measured;    // the detections alone, in the plane frame
  motion::LegMotion motion;
  StsSignals signals;  // what the events are read from
  std::vector<motion::StsEvent> events;
  std::vector<motion::StsEvent> without_seat;  // FoundStsEvents'
  FoundMovement movement;
  std::vector<MarkerReport> markers;
  std::vector<SegmentReport> segments;
  std::vector<OutlierReport> outliers;
  std::optional<LateralReport> lateral;
  std::optional<RebuiltKnee> rebuilt_knee;
  Eigen::Vector2d up = Eigen::Vector2d::UnitY();  // in the plane, as the options had it
  std::optional<PlaneSight> sight;                // of a calibrated plane
  LegMarkers leg_markers;                         // what they are called in the recording, as the options had it
  std::vector<std::string> warnings;
  LegFitSummary summary;
};

// Lateral places of the markers of a trial in three dimensions: by marker, mm, one value per frame, NaN where
// missing.
using LateralPlaces = std::map<std::string, std::vector<double>>;

// Markers other than the leg's are smoothed and bridged each by itself. A sigma of 0 means that it is not known: it is
// then estimated from the marker's own fine structure. Throws Error: a marker of the leg is absent or hardly seen, a
// position is not finite, the markers are no person's leg (persons_leg.h), the result is none of a person's
// (plausibility.h); SolverError: no solution.
//
// With `lateral`, the recording is the projection of three dimensions onto its plane: paths, vectors and segment angles
// are the projection's; the segments' lengths, the knee angle (between the vectors AK and KH in space), its sigma and
// its speed are three-dimensional. The angle's sign is that about the flexion axis: positive in flexion, negative when
// hyperextended. A bend to the side counts less where it is the larger part of a small angle.
LegFitResult FitLeg(const motion::MarkerRecording& recording, const LegView& view, const LegFitOptions& options = {},
                    const LateralPlaces& lateral = {});

// What the recording says of the knee: smallest and largest angle, peak speeds, each with its time. For summary.json,
// with the reports above, under the keys markers, segments, outliers, knee, sit_to_stands, fit.
Json LegFitJson(const LegFitResult& result);

}  // namespace lake::gait
