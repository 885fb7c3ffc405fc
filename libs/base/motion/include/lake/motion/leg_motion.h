// The leg's vectors and angles over time, and the events of its sit-to-stands: the basis of the comparison of human and
// exoskeleton trial.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lake/motion/marker_recording.h"

namespace lake::motion {

enum class Facing { kLeft, kRight };  // the side of the image that the subject faces
enum class Side { kLeft, kRight };    // of the body

std::string_view ToString(Side side);  // left, right

// The leg nearer to the camera: the left one of a subject who faces left in the image.
Side NearLeg(Facing facing);

// The side that a marker's name says, as laboratories name them: L_knee, LKNE, r.ASIS, left ankle, lateral_ankle_r,
// KneeLeft. nullopt for a name without a side, or with both.
std::optional<Side> SideOfName(std::string_view marker);

// The leg in one frame. Vectors are in the leg frame's axes (x anterior, y up); angles are from the vertical, positive
// when the upper end leans forward, and knee_deg = shank_deg − thigh_deg: 0 straight, positive in flexion. NaN where
// not known.
struct LegSample {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  Eigen::Vector2d ak = Eigen::Vector2d::Constant(kUnknown);  // ankle to knee
  Eigen::Vector2d kh = Eigen::Vector2d::Constant(kUnknown);  // knee to hip
  Eigen::Vector2d hw = Eigen::Vector2d::Constant(kUnknown);  // hip to waist
  Eigen::Vector2d ht = Eigen::Vector2d::Constant(kUnknown);  // heel to toe
  double knee_deg = kUnknown;
  double knee_sigma_deg = kUnknown;
  double knee_raw_deg = kUnknown;  // the paper's formula on this frame's own detected markers, signed
  double shank_deg = kUnknown, shank_sigma_deg = kUnknown;
  double thigh_deg = kUnknown, thigh_sigma_deg = kUnknown;
  double trunk_deg = kUnknown, trunk_sigma_deg = kUnknown;
  double foot_deg = kUnknown, foot_sigma_deg = kUnknown;
  double ankle_deg = kUnknown, ankle_sigma_deg = kUnknown;  // positive in dorsiflexion
  double knee_deg_s = kUnknown;                             // angular velocity
  std::optional<int> repetition;                            // from 1
  double percent = kUnknown;                                // of the repetition, 0 to 100
};

// An angle of a sample with its standard deviation, which is the markers' noise: NAME_deg, NAME_sigma_deg.
struct Angle {
  const char* name = nullptr;
  double LegSample::*deg = nullptr;
  double LegSample::*sigma_deg = nullptr;
};

// The leg's markers from the ground up, then others; each is called so where nothing else is said.
enum LegMarker : std::uint8_t { kAnkle, kKnee, kHip, kWaist, kHeel, kToe };
inline constexpr std::array kMarkerNames = {"ankle", "knee", "hip", "waist", "heel", "toe"};

// A segment of the body, from its lower to its upper marker.
struct Segment {
  LegMarker lower, upper;
  const char* vector_name;
  Eigen::Vector2d LegSample::*vector;
  // From the vertical, positive when the upper end leans forward; of a segment that lies on the ground from where it
  // rests, positive when the upper end rises.
  Angle angle;
  // Of a segment that lies: its angle and that of the segment above it, 0 where it rests and the other is upright.
  Angle joint = {};
  double LegSample::*above_deg = nullptr, LegSample::*above_sigma_deg = nullptr;

  bool Lies() const { return joint.name != nullptr; }
};
inline constexpr std::array kSegments = {
    Segment{kAnkle, kKnee, "ak", &LegSample::ak, {"shank", &LegSample::shank_deg, &LegSample::shank_sigma_deg}},
    Segment{kKnee, kHip, "kh", &LegSample::kh, {"thigh", &LegSample::thigh_deg, &LegSample::thigh_sigma_deg}},
    Segment{kHip, kWaist, "hw", &LegSample::hw, {"trunk", &LegSample::trunk_deg, &LegSample::trunk_sigma_deg}},
    Segment{kHeel,
            kToe,
            "ht",
            &LegSample::ht,
            {"foot", &LegSample::foot_deg, &LegSample::foot_sigma_deg},
            {"ankle", &LegSample::ankle_deg, &LegSample::ankle_sigma_deg},
            &LegSample::shank_deg,
            &LegSample::shank_sigma_deg}};

// Of the knee, of the segments and of the joints between them.
std::span<const Angle> Angles();

struct LegMotion {
  LengthUnit unit = LengthUnit::kPx;  // of the vectors
  Facing facing = Facing::kRight;
  std::vector<std::int64_t> frame;
  std::vector<double> time_s;
  std::vector<LegSample> samples;       // one per frame
  std::vector<char> knee_rebuilt = {};  // as MarkerRecording has it
  double foot_rest_sd_deg = 0;          // of where the foot rests, from which its angle and the ankle's are
  // The angles of quiet standing and their standard deviations: where they are known, kinematics.csv has
  // NAME_neutral_deg too, the angles less these.
  std::optional<LegSample> neutral;
};

// The median length of a vector of the leg over the frames in which it is known, in the motion's unit; NaN if there is
// none.
double MedianLength(const LegMotion& motion, Eigen::Vector2d LegSample::*vector);

// One of onset, seat_off, standing, descent, seated; of a squat bottom too; of walking heel_strike, toe_off and, of the
// other leg, heel_strike_other, toe_off_other.
enum class StsEventKind {
  kOnset,
  kSeatOff,
  kStanding,
  kDescent,
  kSeated,
  kBottom,
  kHeelStrike,
  kToeOff,
  kHeelStrikeOther,
  kToeOffOther
};
inline constexpr int kEventKinds = 10;

std::string_view ToString(StsEventKind kind);

struct StsEvent {
  int repetition = 0;  // from 1; of walking 0 before the first heel strike
  StsEventKind kind = StsEventKind::kOnset;
  std::int64_t frame = 0;
  double time_s = 0;
  double sd_s = LegSample::kUnknown;  // of the time, from the fit; in events.csv of walking and squats only
  double alike_sd_s = 0;              // the part of sd_s by which all such events of the person are off together
};

// kinematics.csv; the vectors' columns end in the motion's unit. Reading throws Error naming file, line and column,
// also for times that do not increase.
void WriteKinematicsCsv(const std::filesystem::path& path, const LegMotion& motion);
LegMotion ReadKinematicsCsv(const std::filesystem::path& path);

// events.csv: repetition,event,frame,time_s, of walking and squats sd_s too, in the order of repetitions and, within
// each, of time; reading throws Error for another order.
void WriteEventsCsv(const std::filesystem::path& path, const std::vector<StsEvent>& events);
std::vector<StsEvent> ReadEventsCsv(const std::filesystem::path& path);

}  // namespace lake::motion
