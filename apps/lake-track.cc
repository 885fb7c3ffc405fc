// lake-track: markers, leg vectors and knee angle from a video.
#include "lake/commands/track.h"
#include "program.h"

int main(int argc, char** argv) {
  lake::Program program("lake-track", "Markers, leg vectors and knee angle from a video",
                        "lake-track sit-to-stand.mp4 --camera camera.yaml -o trial");
  lake::commands::TrackRunOptions options;
  program.Add(lake::OptionsOf(options).WithUsual(
      {"markers",      "seed",        "detector", "color",        "crop",      "start",    "end",
       "capture-rate", "camera",      "scale",    "plane-points", "depth",     "movement", "technical",
       "knee-from",    "corrections", "events",   "overlay",      "anonymise", "export",   "list"}));
  return program.Main(
      argc, argv, [&] { return options.video.stem().string(); },
      [&](lake::Run& run) { return lake::commands::RunTrack(options, run); });
}
