// lake-synth: a rendered sit-to-stand recording with its ground truth.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/name_value.h"
#include "lake/synth/population.h"
#include "lake/synth/recording.h"
#include "lake/synth/staging.h"
#include "lake/synth/sts_motion.h"
#include "program.h"

namespace {

using namespace lake;

// What was said on the command line; what was not keeps the preset's value.
struct Arguments {
  std::string scene = "clean", facing = "right", markers = "disc";
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> motion_seed;
  std::string motion_table, exo, camera, distortion;
  std::vector<std::string> hide, depth;
  std::optional<double> walk_in, second_person;
  std::optional<int> repetitions, width, height, crf, reflections, population;
  int sessions = 1;
  std::optional<double> duration, rate, radius_px, shutter, readout, flicker, psf, read_noise, shot_gain, level,
      brightness, exposure, pace, rest, distance, yaw, pitch, roll;
  double warp = 0, skin = 0, start = 0, jitter = 0;
  bool standing = false, exoskeleton = false, colour = false, bright_room = false, glint = false, still = false,
       lossless = false, pictures = false;
};

template <typename T>
void Take(const std::optional<T>& given, T& value) {
  if (given) value = *given;
}

void TakeMotion(const Arguments& a, synth::SceneOptions& scene) {
  synth::StsMotionOptions& motion = scene.motion;
  Take(a.motion_seed, motion.seed);
  Take(a.repetitions, motion.repetitions);
  Take(a.pace, motion.pace);
  Take(a.rest, motion.max_rest_s);
  motion.min_rest_s = std::min(motion.min_rest_s, motion.max_rest_s);
  motion.facing = a.facing == "left" ? motion::Facing::kLeft : motion::Facing::kRight;
  motion.start_standing = a.standing;
  motion.time_warp = a.warp;
  motion.skin_mm = a.skin;
  if (a.still) motion.ankle_sway_mm = motion.body_sway_deg = 0;
  if (!a.exo.empty()) {
    const std::vector<double> p = ParseNumbers(a.exo, 2, "--exo");
    motion.exo_knee_mm = Eigen::Vector2d(p[0], p[1]);
  }
  if (a.repetitions) scene.duration_s = 0;
  scene.motion_table = a.motion_table;
  scene.mirror_table = !a.motion_table.empty() && a.facing == "left";
  if (!a.motion_table.empty()) scene.duration_s = 0;
}

void TakePicture(const Arguments& a, synth::SceneOptions& scene) {
  Take(a.duration, scene.duration_s), Take(a.rate, scene.frame_rate_hz), Take(a.width, scene.width_px),
      Take(a.height, scene.height_px);
  Take(a.radius_px, scene.marker_radius_px), Take(a.shutter, scene.shutter), Take(a.readout, scene.readout_s),
      Take(a.flicker, scene.flicker), Take(a.psf, scene.psf_sigma_px);
  Take(a.read_noise, scene.noise.read_sd), Take(a.shot_gain, scene.noise.gain), Take(a.level, scene.marker_level);
  Take(a.brightness, scene.brightness), Take(a.exposure, scene.exposure), Take(a.reflections, scene.reflections);
  Take(a.distance, scene.distance_mm), Take(a.yaw, scene.yaw_deg), Take(a.pitch, scene.pitch_deg),
      Take(a.roll, scene.roll_deg);
  if (!a.distortion.empty()) std::ranges::copy(ParseNumbers(a.distortion, 5, "--distortion"), scene.distortion.begin());
  scene.start_s = a.start, scene.time_jitter = a.jitter;
  scene.glint = scene.glint || a.glint;
  scene.exoskeleton = a.exoskeleton;
  scene.bright_room = a.bright_room;
  if (a.bright_room && !a.level) scene.marker_level = 18;
  if (a.markers == "aruco") scene.marker_kind = synth::MarkerKind::kAruco;
  scene.colour = a.colour || a.markers == "led";
  if (a.markers == "led") scene.marker_bgr = synth::LedColours();
  if (!a.camera.empty()) {
    scene.camera = camera::ReadCameraProfile(a.camera);
    if (!scene.camera->camera_from_plane)
      throw UsageError(fmt::format("{}: has no plane; a scene needs plane_rvec and plane_tvec", a.camera));
  }
}

// NAME=NUMBERS
std::pair<std::string, std::vector<double>> NamedNumbers(const std::string& text, std::size_t count,
                                                         const char* option) {
  const auto [name, numbers] = SplitNameValue(option, text);
  return {name, ParseNumbers(numbers, count, option)};
}

synth::SceneOptions SceneOf(const Arguments& a) {
  synth::SceneOptions scene = a.scene == "hard" ? synth::HardScene(a.seed) : synth::CleanScene(a.seed);
  TakeMotion(a, scene);
  TakePicture(a, scene);
  for (const std::string& text : a.hide) {
    const auto [marker, numbers] = NamedNumbers(text, 2, "--hide");
    scene.occlusions.push_back({marker, numbers[0], numbers[1]});
  }
  for (const std::string& text : a.depth) {
    const auto [marker, numbers] = NamedNumbers(text, 1, "--depth");
    scene.marker_depth_mm[marker] = numbers[0];
  }
  return scene;
}

void AddMotionOptions(CLI::App& cli, Arguments& a) {
  cli.add_option("--facing", a.facing, "Where the subject looks: left or right")
      ->check(CLI::IsMember({"left", "right"}));
  cli.add_option("--repetitions", a.repetitions, "Stand-ups; the video becomes as long as they take");
  cli.add_option("--motion-seed", a.motion_seed, "Seed of the motion (default: --seed-number)");
  cli.add_option("--walk-in", a.walk_in, "The subject walks in for so many s before the motion begins");
  cli.add_option("--second-person", a.second_person,
                 "Markers of a second person who stands up, so many mm to the right: other_ankle, …");
  cli.add_flag("--standing", a.standing, "Begin upright instead of seated");
  cli.add_option("--pace", a.pace, "Movements take this many times as long");
  cli.add_option("--rest", a.rest, "Longest rest between movements, s");
  cli.add_option("--warp", a.warp, "Rises go through s + WARP sin(pi s) instead of s");
  cli.add_option("--skin", a.skin, "How far markers slide over the skin, mm");
  cli.add_flag("--still", a.still, "No sway of ankle and body");
  cli.add_option("--exo", a.exo, "X,Y: a marker exo_knee, mm from the knee in the shank frame (anterior, upward)");
  cli.add_flag("--exoskeleton", a.exoskeleton, "Draw an exoskeleton whose joint is at exo_knee");
  cli.add_option("--motion-table", a.motion_table,
                 "Markers of this table (time_s, M_x_mm, M_y_mm) instead; --facing left mirrors it")
      ->check(CLI::ExistingFile);
}

void AddPictureOptions(CLI::App& cli, Arguments& a) {
  cli.add_option("--duration", a.duration, "Length of the video, s");
  cli.add_option("--rate", a.rate, "Frame rate, Hz");
  cli.add_option("--width", a.width, "px");
  cli.add_option("--height", a.height, "px");
  cli.add_option("--camera", a.camera, "A camera.yaml with a plane, instead of the scene's camera")
      ->check(CLI::ExistingFile);
  cli.add_option("--radius-px", a.radius_px, "Marker radius in the picture");
  cli.add_option("--distance", a.distance, "Camera to plane, mm");
  cli.add_option("--yaw", a.yaw, "How far the camera looks askance, degrees");
  cli.add_option("--pitch", a.pitch, "How far it looks up or down, degrees");
  cli.add_option("--roll", a.roll, "How far it is tilted, degrees");
  cli.add_option("--distortion", a.distortion, "K1,K2,P1,P2,K3 of the lens");
  cli.add_option("--depth", a.depth, "NAME=MM: a marker stands proud of the plane (may be repeated)");
  cli.add_option("--markers", a.markers, "disc, led (colours, colour video) or aruco")
      ->check(CLI::IsMember({"disc", "led", "aruco"}));
  cli.add_option("--level", a.level, "Grey level of the markers; above 255 they saturate");
  cli.add_option("--brightness", a.brightness, "Factor on everything but the markers");
  cli.add_flag("--bright-room", a.bright_room, "Light wall and clothes, dark markers");
  cli.add_option("--exposure", a.exposure, "Factor on everything");
  cli.add_option("--shutter", a.shutter, "Exposure time as a part of the frame time");
  cli.add_option("--readout", a.readout, "s in which a rolling shutter reads the picture from top to bottom");
  cli.add_option("--flicker", a.flicker, "Amplitude of the changes in brightness");
  cli.add_option("--psf", a.psf, "Standard deviation of the point-spread, px");
  cli.add_option("--read-noise", a.read_noise, "Standard deviation, grey values");
  cli.add_option("--shot-gain", a.shot_gain, "Variance per grey value of level");
  cli.add_option("--reflections", a.reflections, "Fixed bright spots");
  cli.add_flag("--glint", a.glint, "A moving bright spot");
  cli.add_option("--hide", a.hide, "NAME=START_S,LENGTH_S: a hand hides this marker (may be repeated)");
  cli.add_flag("--color", a.colour, "A colour video");
  cli.add_option("--start", a.start, "Time stamp of the first frame, s");
  cli.add_option("--jitter", a.jitter, "Time stamps vary by up to this part of the frame time");
}

// With whoever walks in or stands beside; the camera stays where it is without them.
synth::Scene StagedScene(const Arguments& a) {
  synth::SceneOptions options = SceneOf(a);
  if (!a.walk_in && !a.second_person) return synth::Scene(options);
  if (!options.motion_table.empty()) throw UsageError("--walk-in, --second-person: not with --motion-table");
  options.camera = synth::Scene(options).Profile();
  std::shared_ptr<const synth::MarkerMotion> motion = std::make_shared<synth::StsMotion>(options.motion);
  if (a.walk_in) {
    motion = synth::MakeWalkIn(motion, *a.walk_in);
    if (options.duration_s > 0) options.duration_s += *a.walk_in;
  }
  if (a.second_person) {
    synth::StsMotionOptions other = options.motion;
    ++other.seed;
    motion = synth::MakeTwoPeople(motion, std::make_shared<synth::StsMotion>(other), *a.second_person);
  }
  return synth::Scene(options, motion);
}

// A cohort instead of a recording.
Json RenderPopulation(const Arguments& a, Run& run) {
  synth::PopulationOptions options;
  options.seed = a.seed, options.people = *a.population, options.sessions = a.sessions;
  const synth::SceneOptions scene = SceneOf(a);
  const std::vector<synth::Session> sessions = synth::DrawPopulation(options, scene.motion);
  std::vector<std::string> names = {"participants.tsv", "cohort.yaml", "truth.csv"};
  for (const synth::Session& session : sessions)
    for (const char* trial : {"human", "exo"})
      for (const char* file : {"video.mp4", "truth.csv", "camera.yaml", "scene.json"})
        names.push_back((session.Folder() / trial / file).string());
  run.Begin(names);
  synth::WritePopulation(sessions, scene, run.Folder());
  return {{"people", options.people}, {"sessions", options.sessions}};
}

std::string Report(const Json& summary) {
  if (summary.contains("people"))
    return fmt::format("{} people, {} sessions each\n", summary["people"].get<int>(), summary["sessions"].get<int>());
  std::string hidden;
  for (const auto& [name, frames] : summary["hidden_frames"].items())
    if (frames.get<int>() > 0) hidden += fmt::format(", {} hidden in {}", name, frames.get<int>());
  return fmt::format("{} frames{}: {}\n", summary["frames"].get<int>(), hidden, summary["video"].get<std::string>());
}

}  // namespace

int main(int argc, char** argv) {
  Program program("lake-synth", "Renders a sit-to-stand recording with its ground truth.",
                  "lake-synth --scene hard --seed-number 7 --facing left --crf 23 -o renderings/hard7");
  Arguments a;
  CLI::App& cli = program.Cli();
  cli.add_option("--scene", a.scene, "clean (720p60) or hard (1080p60, oblique, blurred, reflections, hands)")
      ->check(CLI::IsMember({"clean", "hard"}));
  cli.add_option("--seed-number", a.seed, "Random seed");
  AddMotionOptions(cli, a);
  AddPictureOptions(cli, a);
  cli.add_option("--crf", a.crf, "H.264 quality, 17 (fine) to 28 (coarse) (default: 17 clean, 23 hard)")
      ->check(CLI::Range(0, 51));
  cli.add_flag("--lossless", a.lossless, "Keep every grey value");
  cli.add_option("--population", a.population,
                 "A cohort for lake cohort instead: so many people, drawn by lot, with and without exoskeleton")
      ->check(CLI::PositiveNumber);
  cli.add_option("--sessions", a.sessions, "With --population: sessions of each")->check(CLI::PositiveNumber);
  cli.add_flag("--pictures", a.pictures, "frames/00000.png … instead of a video");

  return program.Main(
      argc, argv, [&] { return fmt::format("synth-{}-{}", a.scene, a.seed); },
      [&](Run& run) {
        for (const std::string& file : {a.motion_table, a.camera})
          if (!file.empty()) run.AddInput(file);
        if (a.population) return RenderPopulation(a, run);
        const synth::Scene scene = StagedScene(a);
        synth::RecordingOptions recording{a.crf.value_or(a.scene == "hard" ? 23 : 17), a.lossless, a.pictures,
                                          "veryfast", run.Quiet()};
        std::vector<std::string> names = {"truth.csv", "camera.yaml", "scene.json"};
        if (!a.pictures) names.push_back("video.mp4");
        for (int frame = 0; a.pictures && frame < scene.Frames(); ++frame)
          names.push_back(fmt::format("frames/{:05d}.png", frame));
        run.Begin(names);
        const std::filesystem::path& folder = run.Folder();
        const synth::RecordingSummary written = synth::WriteRecording(scene, folder, recording);
        Json results = {{"video", (folder / (a.pictures ? "frames/%05d.png" : "video.mp4")).string()},
                        {"frames", written.frames}};
        for (std::size_t m = 0; m < written.markers.size(); ++m)
          results["hidden_frames"][written.markers[m]] = written.hidden_frames[m];
        return results;
      },
      Report);
}
