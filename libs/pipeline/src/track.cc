#include "lake/pipeline/track.h"

namespace lake {

Json RunTrack(const TrackRunOptions& options, Run& run) {
  run.AddInput(options.video);
  TrackResult tracked = TrackMarkers(options.video, options.track);
  WriteMarkerCsv(run.Result("tracks.csv"), tracked.recording);
  return {{"frames", tracked.recording.Frames()}, {"tracklets", tracked.tracklets}};
}

}  // namespace lake
