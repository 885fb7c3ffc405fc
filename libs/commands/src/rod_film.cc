#include "rod_film.h"

#include "lake/core/error.h"
#include "lake/core/run.h"
#include "lake/motion/marker_recording.h"

namespace lake::commands {
namespace {

const motion::MarkerTrack& TrackOf(const motion::MarkerRecording& recording, const std::string& name,
                                   const std::string& file) {
  if (const motion::MarkerTrack* track = recording.Find(name)) return *track;
  throw Fail("{}: no marker '{}'; --rod-markers BODY,ROD names the two on the actuator", file, name);
}

}  // namespace

actuator::ActuatorFilm ReadRodFilm(const std::filesystem::path& folder, const std::vector<std::string>& names) {
  const std::optional<std::filesystem::path> found = FindResult(folder, "trajectory.csv");
  if (!found)
    throw Fail("{}: no trajectory.csv in it; track the video with --scale or a calibrated plane, lengths in mm",
               folder.string());
  if (names.size() != 2) throw UsageError("--rod-markers: give two names, BODY,ROD");
  const std::filesystem::path& file = *found;
  const motion::MarkerRecording recording = motion::ReadMarkerCsv(file);
  const motion::MarkerTrack &body = TrackOf(recording, names[0], file.string()),
                            &rod = TrackOf(recording, names[1], file.string());
  actuator::ActuatorFilm film;
  for (std::size_t i = 0; i < recording.Frames(); ++i) {
    if (body.samples[i].status != motion::SampleStatus::kDetected ||
        rod.samples[i].status != motion::SampleStatus::kDetected)
      continue;
    film.time_s.push_back(recording.time_s[i]);
    film.length_mm.push_back((rod.samples[i].position - body.samples[i].position).norm());
  }
  return film;
}

}  // namespace lake::commands
