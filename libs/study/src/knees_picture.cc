#include "knees_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "lake/core/run.h"
#include "lake/motion/marker_recording.h"
#include "lake/overlay/knees_picture.h"
#include "lake/tracking/naming.h"
#include "lake/video/image.h"
#include "lake/video/video_reader.h"

namespace lake::study {
namespace {

namespace fs = std::filesystem;

struct Apart {
  std::size_t row = 0;
  double mm = 0;
};

// The row of the median distance, of those that show both.
std::optional<Apart> UsuallyApart(const motion::MarkerTrack& knee, const motion::MarkerTrack& joint) {
  std::vector<std::pair<double, std::size_t>> apart;
  for (std::size_t row = 0; row < knee.samples.size(); ++row) {
    const motion::MarkerSample &a = knee.samples[row], &b = joint.samples[row];
    if (a.status == motion::SampleStatus::kDetected && b.status == motion::SampleStatus::kDetected)
      apart.emplace_back((a.position - b.position).norm(), row);
  }
  if (apart.empty()) return std::nullopt;
  const auto middle = apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2);
  std::nth_element(apart.begin(), middle, apart.end());
  return Apart{middle->second, middle->first};
}

}  // namespace

void DrawKneesOf(const StudyTrial& trial, const fs::path& exo, const std::string& joint, Run& run) {
  if (!trial.IsVideo() || joint == "knee" || !fs::is_regular_file(exo / "trajectory.csv")) return;
  const auto& options = std::get<commands::TrackRunOptions>(trial.work);
  const motion::MarkerRecording px = motion::ReadMarkerCsv(exo / "tracks.csv"),
                                mm = motion::ReadMarkerCsv(exo / "trajectory.csv");
  const motion::MarkerTrack *knee = mm.Find("knee"), *worn = mm.Find(joint);
  if (!knee || !worn) return;
  const auto apart = UsuallyApart(*knee, *worn);
  if (!apart) return;
  const auto place = [&](const std::string& name) { return px.Find(name)->samples[apart->row]; };
  overlay::KneesPicture picture{.frame = video::ReadLuma(options.video, px.frame[apart->row], options.track.reader),
                                .knee = place("knee").position,
                                .joint = place(joint).position,
                                .leg = {},
                                .distance = fmt::format("{:.0f} mm", apart->mm)};
  for (const std::string_view name : tracking::kLegMarkers)
    if (const motion::MarkerTrack* marker = px.Find(std::string(name)); marker && marker->samples[apart->row].IsKnown())
      picture.leg.push_back(marker->samples[apart->row].position);
  video::WriteImage(run.Result("knees.png"), overlay::DrawKnees(picture));
}

}  // namespace lake::study
