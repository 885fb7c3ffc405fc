// Which frames show the picture before them once more, by the markers' motion (lake/tracking/frame_times.h).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lake/motion/marker_recording.h"

namespace lake::tracking {

inline constexpr double kLeastStepPx =
    0.3;  // root mean square over the markers: smaller steps are no motion to speak of

// How all markers moved from one frame to another: two numbers for each marker that is seen in both.
struct JointStep {
  std::vector<std::optional<Eigen::Vector2d>> markers;
  int seen = 0;
  double rms_px = 0;
};

// Frames by their place in the recording.
JointStep StepBetween(const motion::MarkerRecording& recording, std::size_t from, std::size_t to);

// The usual time between these frames, s.
double UsualInterval(const motion::MarkerRecording& recording, const std::vector<std::size_t>& frames);

// Frames by their place in a recording, whose times it corrects.
class RepeatedFrames {
 public:
  // `known`: numbers of frames whose picture told already, increasing.
  RepeatedFrames(const std::vector<std::int64_t>& known, motion::MarkerRecording& recording);

  // Marks frames in which all markers stand still at once that move on before and after.
  void FindStandstills();

  // Where frames repeat as those of a lower rate do, marks all that it repeats. Returns the rate, Hz, with the times
  // corrected, if they were captured at it; else 0.
  double TakeLowerRate();

  void Mark(std::size_t frame) { repeated_[frame] = 1; }
  std::vector<std::size_t> Fresh() const;  // frames that show something new

  // Repeated frames have no time of their own: evenly between the new ones on either side.
  void SpreadTimes();

  // Takes their samples out of the recording; returns their numbers.
  std::vector<std::int64_t> Remove();

 private:
  // A lower rate: source frame floor(ratio · i + phase) is shown in frame i.
  struct LowerRate {
    double ratio = 1, phase = 0;

    double Source(std::size_t i) const;
    bool Repeats(std::size_t i) const { return i > 0 && Source(i) == Source(i - 1); }
  };

  std::optional<std::size_t> NewBefore(std::size_t i) const;
  void MarkStandstillFrom(std::size_t first);
  std::vector<std::size_t> TellingFrames() const;
  std::optional<LowerRate> FindLowerRate() const;
  double Roughness(const std::vector<double>& time_s) const;

  motion::MarkerRecording& recording_;
  double frame_s_ = 0;          // between frames, usually
  std::vector<char> repeated_;  // 0 or 1 per frame
};

}  // namespace lake::tracking
