// Where an exoskeleton's joint sits against the knee that wears it, after some rises, and how to move it.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lake/compare/uncertainty_budget.h"
#include "lake/gait/leg_view.h"
#include "lake/gait/rolling_shutter.h"
#include "lake/motion/marker_recording.h"
#include "lake/video/video_reader.h"

namespace lake::live {

// One rise. Joint less knee, mm, in the shank's frame: x anterior, y from ankle to knee.
struct RiseOffset {
  double onset_s = 0, standing_s = 0;
  Eigen::Vector2d mean_mm = Eigen::Vector2d::Zero();      // over the rise
  Eigen::Vector2d noise_sd_mm = Eigen::Vector2d::Zero();  // of that, from the markers' noise and the events' times
  double remainder_mm = 0;                                // RMS of what a move of the joint leaves
  // What the joint's depth against the knee's leaves open of that place.
  Eigen::Vector2d parallax_sd_mm = Eigen::Vector2d::Constant(compare::kSkinDepth_mm * compare::kViewSlope);
  double rebuilt_sd_mm = 0;  // of the knee, where technical markers replace its marker
};

struct RiseFinding {
  gait::LegView view;
  gait::RollingShutter shutter;
  video::VideoInfo video;
  std::string joint = "exo_knee";
  std::shared_ptr<const gait::LearntKnee> knee_from = {};  // rebuilds a hidden knee
  Eigen::Vector2d marker_at_mm = Eigen::Vector2d::Zero();  // of that marker, less the joint's axis; shank's frame
};

struct FoundRises {
  std::vector<RiseOffset> rises;
  std::string why_last_is_left_out;  // a sentence; empty if the last whole rise is among them
};

// The whole rises in a recording (px, measurements with the fits' own sigmas), as lake compare measures them: sigmas
// calibrated, the leg fitted, the joint registered against the knee. Throws Error as CalibrateSigmas, FitLeg and
// RegisterTrial do, also where there is no rise yet.
FoundRises FindRiseOffsets(motion::MarkerRecording recording, const RiseFinding& finding);

// The mean of rises between which the joint was not moved. Half widths of 95 % intervals, per axis.
struct JointPlace {
  int rises = 0;
  Eigen::Vector2d offset_mm = Eigen::Vector2d::Zero();
  // Of the markers: their noise and how the rises differ (Student's t), the plane's scale, parallax. What moving the
  // joint by −offset_mm leaves lies in it.
  Eigen::Vector2d half_width_mm = Eigen::Vector2d::Zero();
  // Of that, what no rise narrows: scale, parallax, a rebuilt knee.
  Eigen::Vector2d fixed_half_width_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d parallax_sd_mm = Eigen::Vector2d::Zero();
  // Of the joint beneath the knee's marker: with the marker's placement and soft tissue.
  Eigen::Vector2d anatomical_half_width_mm = Eigen::Vector2d::Zero();

  double DistanceMm() const { return offset_mm.norm(); }
  double UncertaintyMm() const { return half_width_mm.maxCoeff(); }
  // Whether most of UncertaintyMm() is of the rises, so that one more narrows it.
  bool DoRisesNarrow() const;
};

// Needs one rise. Takes the place of the marker on the exoskeleton as known exactly.
JointPlace PlaceOf(std::span<const RiseOffset> rises, const compare::RecordingBudgetOptions& budget = {});

// UncertaintyMm() of a joint at the knee after however many rises; a smaller tolerance is never kept for certain.
double LeastUncertaintyMm(const RiseOffset& at_knee_without_noise = {});

// "Move the joint 12 mm back and 30 mm down (± 3 mm)"; a part that is smaller than its interval is not said. Of a joint
// within the tolerance: to leave it.
std::string MoveText(const JointPlace& place, double tolerance_mm);

// "4 mm nearer to the knee than before the last move (± 3 mm)"; not what is smaller than the interval.
std::string ChangeText(const JointPlace& before, const JointPlace& now);

enum class ToleranceVerdict { kWithin, kBeyond, kUndecided };  // undecided: its interval holds the limit
ToleranceVerdict JudgeTolerance(const JointPlace& place, double tolerance_mm);
std::string ToString(ToleranceVerdict verdict);  // within, beyond, undecided

// Which part of a session's recording becomes its trial, in s of the recording; nullopt: its own begin or end.
struct TrialPart {
  std::optional<double> begin_s, end_s;
};

// Of what a person asked for, the part with one place of the joint: from the last move after which there was a rise to
// the move after it. Where there was no rise all that was asked for. `moves_s`: when the joint was moved, increasing;
// `onsets_s`: of the rises.
TrialPart PartOfTrial(const TrialPart& asked, std::span<const double> moves_s, std::span<const double> onsets_s);

}  // namespace lake::live
