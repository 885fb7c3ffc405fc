// lake-track: markers, leg vectors and knee angle from a video.
#include <algorithm>

#include "lake/commands/gait.h"
#include "lake/commands/track.h"
#include "lake/commands/track_text.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/name_value.h"
#include "program.h"

namespace {

// What the command line says, as text where it needs to be parsed further.
struct Arguments {
  std::string video, markers = "ankle,knee,hip,waist", detector = "reflective", polarity = "bright",
                     dictionary = "DICT_4X4_50";
  std::string camera, scale, crop, vertical, filter = "spline", corrections, exports;
  std::vector<std::string> seeds, colors, depths;
  std::optional<double> start_s, end_s;
  double capture_rate_hz = 0, cutoff_hz = 0;
  int rotate_deg = 0;
  std::optional<double> readout_s;
  bool overlay = true;
};

void Declare(CLI::App& cli, Arguments& a) {
  cli.add_option("video", a.video, "Video, or image sequence as frames/%05d.png")->required();
  cli.add_option("--markers", a.markers,
                 "Names of the markers to find; ankle, knee, hip, waist are understood as the leg");
  cli.add_option("--seed", a.seeds, "NAME=X,Y[@FRAME]: where a marker is, in px of a frame (may be repeated)");
  cli.add_option("--detector", a.detector, "What the markers are")
      ->check(CLI::IsMember({"reflective", "color", "template", "aruco"}));
  cli.add_option("--color", a.colors, "\"#RRGGBB\", one for all markers or one for each, for --detector color");
  cli.add_option("--dictionary", a.dictionary, "For --detector aruco; ids 0, 1, … are the markers in order");
  cli.add_option("--polarity", a.polarity, "Markers brighter or darker than what is round them")
      ->check(CLI::IsMember({"bright", "dark"}));
  cli.add_option("--camera", a.camera, "camera.yaml: intrinsics and, if it has one, the sagittal plane");
  cli.add_option("--scale", a.scale, "X1,Y1,X2,Y2,LENGTH_MM: a scale bar in px, without a calibrated plane");
  cli.add_option("--crop", a.crop, "X,Y,W,H: look only there");
  cli.add_option("--start", a.start_s,
                 "Look only from this time on, s of the file's own time (default: its beginning)");
  cli.add_option("--end", a.end_s, "Look only up to this time, s (default: the file's end)");
  cli.add_option("--capture-rate", a.capture_rate_hz, "Hz at which a slow-motion file was recorded")
      ->check(CLI::PositiveNumber);
  cli.add_option("--rotate", a.rotate_deg, "Turn the pictures clockwise by 90, 180 or 270, beyond what the file says")
      ->check(CLI::IsMember({0, 90, 180, 270}));
  cli.add_option(
      "--readout", a.readout_s,
      "s in which a rolling shutter reads the picture from top to bottom (default: the camera file's, else 0)");
  cli.add_option(
      "--vertical", a.vertical,
      "X1,Y1,X2,Y2: a plumb line in the picture, in px, in any direction; or auto: from the leg as it stands");
  cli.add_option("--depth", a.depths,
                 "NAME=MM: how far a marker stands proud of the calibrated plane (may be repeated)");
  cli.add_option("--filter", a.filter, "How positions and angles are smoothed")
      ->check(CLI::IsMember({"spline", "butterworth", "none"}));
  cli.add_option("--cutoff", a.cutoff_hz, "Hz; default: found from the data (spline), 6 (butterworth)")
      ->check(CLI::PositiveNumber);
  cli.add_option("--corrections", a.corrections,
                 "frame,marker,x_px,y_px rows that overrule the detector; empty: not visible");
  cli.add_flag("--overlay,!--no-overlay", a.overlay, "Write overlay.mp4");
  cli.add_option("--export", a.exports, "Also write trc,mot,c3d (mm), tracker,trk,kinovea,kva");
}

template <std::size_t kCount>
std::optional<std::array<double, kCount>> ParseOptional(const std::string& option, const std::string& text) {
  if (text.empty()) return std::nullopt;
  std::array<double, kCount> values;
  std::ranges::copy(lake::ParseNumbers(text, kCount, option), values.begin());
  return values;
}

lake::tracking::TrackOptions MakeTrackOptions(const Arguments& a) {
  lake::tracking::TrackOptions options;
  options.names = lake::SplitText(a.markers, ',');
  for (const std::string& seed : a.seeds) options.seeds.push_back(lake::commands::ParseSeed(seed));
  options.detector = lake::commands::ParseDetector(a.detector);
  options.polarity = lake::commands::ParsePolarity(a.polarity);
  options.colors = a.colors;
  options.dictionary = a.dictionary;
  if (const auto crop = ParseOptional<4>("--crop", a.crop)) options.crop = lake::commands::CropOf(*crop);
  options.reader.start_s = a.start_s, options.reader.end_s = a.end_s;
  if (a.start_s && a.end_s && *a.end_s < *a.start_s)
    throw lake::UsageError(fmt::format("--end {} s is before --start {} s", *a.end_s, *a.start_s));
  options.reader.capture_rate_hz = a.capture_rate_hz;
  options.reader.rotate_deg = a.rotate_deg;
  return options;
}

lake::commands::TrackRunOptions MakeRunOptions(const Arguments& a) {
  lake::commands::TrackRunOptions options;
  options.video = a.video;
  options.track = MakeTrackOptions(a);
  options.fit.filter = lake::gait::ParseLegFilter(a.filter);
  if (a.cutoff_hz > 0) options.fit.cutoff_hz = a.cutoff_hz;
  if (!a.camera.empty()) options.camera = a.camera;
  if (!a.corrections.empty()) options.corrections = a.corrections;
  options.scale = ParseOptional<5>("--scale", a.scale);
  options.vertical_from_leg = a.vertical == "auto";
  if (!options.vertical_from_leg) options.vertical = ParseOptional<4>("--vertical", a.vertical);
  options.readout_s = a.readout_s;
  for (const std::string& depth : a.depths) {
    const auto [name, mm] = lake::SplitNameValue("--depth", depth);
    options.depth_mm[name] = lake::ParseNumbers(mm, 1, "--depth " + name).front();
  }
  options.overlay = a.overlay;
  options.exports = lake::SplitText(a.exports, ',');
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  lake::Program program("lake-track", "Markers, leg vectors and knee angle from a video",
                        "lake-track sit-to-stand.mp4 --camera camera.yaml -o trial");
  Arguments arguments;
  Declare(program.Cli(), arguments);
  return program.Main(
      argc, argv, [&] { return std::filesystem::path(arguments.video).stem().string(); },
      [&](lake::Run& run) { return lake::commands::RunTrack(MakeRunOptions(arguments), run); },
      lake::commands::GaitReport);
}
