// Where markers on the skin of shank or thigh carry the knee's marker, learnt from a trial that shows it: what replaces
// the marker where an exoskeleton's joint covers it.
//
// In the frame of a segment's markers the knee's is a polynomial in flexion. Lengths in mm, angles in degrees; standard
// deviations are per axis in the sagittal plane.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/gait/leg_fit.h"

namespace lake::gait {

// shank=A,B and thigh=C,D. Throws UsageError for another segment, or fewer than two markers.
TechnicalMarkers ParseSegmentMarkers(const OptionTexts& texts, const std::string& said);
void Describe(TechnicalMarkers& technical, OptionList& options);                        // --technical
void AddTechnical(const TechnicalMarkers& technical, std::vector<std::string>& names);  // those not among them yet
Option& DescribeKneeFrom(std::optional<std::filesystem::path>& trial, OptionList& options);

// The segment's frame has its origin at the mean of the markers' mean places, x anterior, y from its lower to its upper
// end, z to the person's right.
struct LearntKnee {
  std::string trial = {};                 // where it was learnt, for messages
  double shank_mm = 0;                    // ankle to knee
  std::string segment = {};               // shank or thigh
  std::vector<std::string> markers = {};  // technical ones, perhaps with the segment's own end (ankle, hip)
  Eigen::Matrix3Xd shape_mm = {};         // a column per marker
  bool in_space = false;                  // posed in three dimensions; else in the sagittal plane
  double strain_mm = 0;             // by so much markers leave their places in the shape, per axis, root mean square
  double from_deg = 0, to_deg = 0;  // flexion that was seen
  Eigen::Matrix3Xd knee_mm = {};    // columns are coefficients of 1, u, u²; u is −1 … 1 over the range of flexion
  std::vector<double> residual_mm = {};  // SD where the repetition itself was left out, in equal parts of the range
};

// Learns from the frames that show knee, ankle, hip and technical markers. Segment, degree, and whether the segment's
// own end is among its markers, are those with the smallest error where each repetition is left out in turn; without
// two repetitions, each quarter of the recording. `lateral` as for FitLeg. Throws Error: a marker is absent, lengths
// are in px, or the markers are seen together in too few frames.
LearntKnee LearnKnee(const LegFitResult& fit, const TechnicalMarkers& technical, const LateralPlaces& lateral = {});

// Where the markers of one frame carry the knee, and which way the person faces by them, if that is not known; nullopt
// where too few of them are seen, or the flexion is none that was learnt.
struct CarriedKnee {
  Eigen::Vector2d in_plane;
  motion::Facing facing = motion::Facing::kRight;
};
std::optional<CarriedKnee> CarriedKneeIn(const motion::MarkerRecording& frame, const LegView& view,
                                         const LearntKnee& learnt, const std::optional<motion::Facing>& facing);

// For summary.json under `kLearntKnee`, and back from a summary in a folder. Throws Error naming the summary.
inline constexpr const char* kLearntKnee = "learnt_knee";
Json LearntKneeJson(const LearntKnee& knee);
LearntKnee ReadLearntKnee(const std::filesystem::path& trial);
std::filesystem::path LearntKneeFile(const std::filesystem::path& trial);  // that is read
void ReadKneeFrom(LegFitOptions& options);                                 // of --knee-from, if it is given

}  // namespace lake::gait
