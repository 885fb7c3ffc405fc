#include "lake/gait/standing_leg.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"

namespace lake::gait {

Eigen::Vector2d UpFromStandingLeg(const motion::MarkerRecording& recording, const LegView& view,
                                  const LegMarkers& names) {
  constexpr double kStraight_deg = 25, kStraightestShare = 0.05;
  constexpr std::size_t kLeastFrames = 3;
  std::array<const motion::MarkerTrack*, 3> tracks;
  for (std::size_t m = 0; const std::string* name : {&names.ankle, &names.knee, &names.hip}) {
    tracks[m] = recording.Find(*name);
    if (!tracks[m++]) throw Fail("the vertical cannot be found from the leg: no marker '{}'", *name);
  }
  struct Stance {
    double knee_deg;
    Eigen::Vector2d up;
  };
  std::vector<Stance> stances;
  for (std::size_t i = 0; i < recording.Frames(); ++i) {
    std::array<Eigen::Vector2d, 3> at;
    bool seen = true;
    for (std::size_t m = 0; m < 3; ++m) {
      const motion::MarkerSample& sample = tracks[m]->samples[i];
      seen = seen && sample.status == motion::SampleStatus::kDetected;
      if (seen) at[m] = PlaneFromRecorded(view, sample.position, view.Depth(tracks[m]->name));
    }
    if (seen) stances.push_back({std::abs(KneeAngleDeg(at[1] - at[0], at[2] - at[1])), (at[2] - at[0]).normalized()});
  }
  std::sort(stances.begin(), stances.end(), [](const Stance& a, const Stance& b) { return a.knee_deg < b.knee_deg; });
  const auto count = std::max(kLeastFrames, static_cast<std::size_t>(kStraightestShare * stances.size()));
  if (stances.size() < count || stances[count - 1].knee_deg > kStraight_deg)
    throw Fail(
        "the vertical cannot be found from the leg: its knee never comes within {}° of straight; give a plumb line",
        kStraight_deg);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < count; ++i) sum += stances[i].up;
  return sum.normalized();
}

}  // namespace lake::gait
