#include "lake/review/comparison_page.h"

#include <algorithm>
#include <limits>

#include "column.h"
#include "lake/core/json_or_null.h"
#include "lake/review/frame_store.h"
#include "page_server.h"

namespace lake::review {
namespace {

// The marker's place in each frame of the motion.
Json MarkerJson(const motion::MarkerRecording& tracks, const motion::MarkerTrack& track,
                const std::vector<std::int64_t>& frames) {
  const auto axis = [&](int i) {
    return Column(frames.size(), [&](std::size_t row) {
      const auto found = std::lower_bound(tracks.frame.begin(), tracks.frame.end(), frames[row]);
      if (found == tracks.frame.end() || *found != frames[row]) return std::numeric_limits<double>::quiet_NaN();
      const motion::MarkerSample& sample = track.samples[static_cast<std::size_t>(found - tracks.frame.begin())];
      return sample.IsKnown() ? sample.position[i] : std::numeric_limits<double>::quiet_NaN();
    });
  };
  return {{"name", track.name}, {"x", axis(0)}, {"y", axis(1)}};
}

Json TrialJson(const ComparedVideo& trial, const video::VideoInfo& info) {
  const motion::LegMotion& motion = trial.motion;
  Json repetition = Json::array(), markers = Json::array();
  for (const motion::LegSample& sample : motion.samples) repetition.push_back(ValueOrNull(sample.repetition));
  for (const motion::MarkerTrack& track : trial.tracks.markers)
    markers.push_back(MarkerJson(trial.tracks, track, motion.frame));
  return {{"name", trial.name},
          {"marker", trial.marker},
          {"width", info.width},
          {"height", info.height},
          {"frame", motion.frame},
          {"repetition", repetition},
          {"percent", Column(motion.samples.size(), [&](std::size_t row) { return motion.samples[row].percent; })},
          {"markers", markers},
          {"rises", trial.rises}};
}

FrameStoreOptions HalfTheMemory() {
  FrameStoreOptions options;
  options.most_bytes /= 2;
  return options;
}

void AddFrames(const std::string& path, FrameStore& frames, PageServer& page) {
  page.GetOther(path, [&frames](const LocalRequest& request) {
    return LocalReply{.type = "image/jpeg", .body = *frames.Frame(FrameNumber(request.rest)).jpeg, .may_keep = true};
  });
}

}  // namespace

void ServeComparison(const PageOptions& options, const ComparedPair& pair) {
  FrameStore human(pair.human.video, pair.human.reader, HalfTheMemory()),
      exo(pair.exo.video, pair.exo.reader, HalfTheMemory());
  PageServer page(options, [] { return Json{{"mode", "comparison"}}; });
  page.Get("comparison", [&] {
    return Json{{"name", pair.name},
                {"human", TrialJson(pair.human, human.Info())},
                {"exo", TrialJson(pair.exo, exo.Info())},
                {"curves", pair.curves}};
  });
  AddFrames("human/", human, page);
  AddFrames("exo/", exo, page);
  page.Serve([] { return false; });
}

}  // namespace lake::review
