// lake-track: markers, leg vectors and knee angle from a video.
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/pipeline/track.h"
#include "program.h"

namespace {

// NAME=X,Y[@FRAME]
lake::MarkerSeed ParseSeed(const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos) throw lake::UsageError(fmt::format("--seed '{}': write it as NAME=X,Y or NAME=X,Y@FRAME", text));
  lake::MarkerSeed seed;
  seed.name = text.substr(0, equals);
  std::string place = text.substr(equals + 1);
  if (const auto at = place.find('@'); at != std::string::npos) {
    const std::vector<double> frame = lake::ParseNumbers(place.substr(at + 1), 1, "--seed " + seed.name + ": frame");
    if (frame[0] < 0 || frame[0] != static_cast<double>(static_cast<std::int64_t>(frame[0])))
      throw lake::UsageError(fmt::format("--seed '{}': the frame is a whole number from 0", text));
    seed.frame = static_cast<std::int64_t>(frame[0]);
    place.resize(at);
  }
  const std::vector<double> xy = lake::ParseNumbers(place, 2, "--seed " + seed.name);
  seed.position = {xy[0], xy[1]};
  return seed;
}

}  // namespace

int main(int argc, char** argv) {
  lake::Program program("lake-track", "Markers, leg vectors and knee angle from a video",
                        "lake-track sit-to-stand.mp4 --camera camera.yaml -o trial");
  lake::TrackRunOptions options;
  std::string video, markers = "ankle,knee,hip,waist";
  std::vector<std::string> seeds;
  CLI::App& cli = program.Cli();
  cli.add_option("video", video, "Video, or image sequence as frames/%05d.png")->required();
  cli.add_option("--markers", markers, "Names of the markers to find");
  cli.add_option("--seed", seeds, "NAME=X,Y[@FRAME]: where a marker is, in px");
  return program.Main(
      argc, argv, [&] { return std::filesystem::path(video).stem().string(); },
      [&](lake::Run& run) {
        options.video = video;
        options.track.names = lake::SplitText(markers, ',');
        for (const std::string& seed : seeds) options.track.seeds.push_back(ParseSeed(seed));
        options.track.quiet = run.Quiet();
        return lake::RunTrack(options, run);
      });
}
