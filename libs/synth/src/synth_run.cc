#include "lake/synth/synth_run.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "lake/core/counted.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/name_value.h"
#include "lake/synth/population.h"
#include "lake/synth/recording.h"
#include "lake/synth/staging.h"

namespace lake::synth {
namespace {

void DescribeMotion(SynthRunOptions& o, OptionList& options) {
  const OptionList::Choices<motion::Facing> sides = {{"left", motion::Facing::kLeft},
                                                     {"right", motion::Facing::kRight}};
  options.AddChoice("facing", o.facing, sides, "Where the subject looks");
  const OptionList::Choices<SynthRunOptions::Drawn> movements = {{"sit-to-stand", SynthRunOptions::Drawn::kSitToStand},
                                                                 {"walking", SynthRunOptions::Drawn::kWalking}};
  options.AddChoice("movement", o.drawn, movements, "What is drawn");
  options.Add("repetitions", o.repetitions, "Rises, or strides in each pass; the video becomes as long as they take")
      .AtLeast(1);
  options.Add("motion-seed", o.motion_seed, "Seed of the motion").Otherwise("--seed-number");
  options.Add("walk-in", o.walk_in_s, "The subject walks in for so long before the motion begins").Unit("s").Positive();
  options
      .Add("second-person", o.second_person_mm,
           "Markers of a second person who stands up, so far to the right: other_ankle, …")
      .Unit("mm");
  options.Add("standing", o.standing, "Begin upright instead of seated");
  options.Add("pace", o.pace, "Movements take this many times as long").Positive();
  options.Add("rest", o.rest_s, "Longest rest between movements").Unit("s").NotNegative();
  options.Add("warp", o.warp, "Rises go through s + WARP sin(pi s) instead of s");
  options.Add("skin", o.skin_mm, "How far markers slide over the skin").Unit("mm").NotNegative();
  options.Add("still", o.still, "No sway of ankle and body");
  options.Add("exo", o.exo_knee_mm, "A marker exo_knee, so far from the knee in the shank frame: anterior, upward")
      .Unit("mm")
      .Value("X,Y");
  options.Add("exoskeleton", o.exoskeleton, "Draw an exoskeleton whose joint is at exo_knee");
  options.Add("hub", o.hub_mm, "Radius of an opaque disc on that joint, which hides what is behind it")
      .Unit("mm")
      .NotNegative();
  options.Add("motion-table", o.motion_table,
              "Markers of this table (time_s, M_x_mm, M_y_mm) instead; --facing left mirrors it");
  options.Add("motion", o.motion.file,
              "A recorded person instead: a file of markers in space (TRC, C3D) or in a plane; seen from the side that "
              "--facing says");
  Describe(o.motion.reading, options);
  options
      .Add("extra-markers", o.motion.extra_markers,
           "With --motion: further markers of the file; of a drawn walk: heel, toe, other_ankle, …; of a drawn "
           "sit-to-stand: shank1, shank2")
      .Value("NAME,...");
  options
      .Add("stride", o.stride_s,
           "Of a walk, the duration of a stride; with --motion the stride from --begin on is repeated")
      .Unit("s")
      .Positive();
  options.Add("stride-length", o.stride_mm, "Of a drawn walk").Unit("mm").Positive();
  options.Add("treadmill", o.treadmill, "Of a walk: without the mean travel");
  options.Add("passes", o.passes, "Of a walk: times through the picture, --rest apart; the person leaves and enters it")
      .AtLeast(1);
  options.Add("begin", o.motion.begin_s, "With --motion: begin so long after its first frame").Unit("s").NotNegative();
}

void DescribeCamera(SynthRunOptions& o, OptionList& options) {
  options.Add("duration", o.duration_s, "Length of the video").Unit("s").Positive();
  options.Add("rate", o.rate_hz, "Frame rate").Unit("Hz").Positive();
  options.Add("width", o.width_px, "Of the picture").Unit("px").AtLeast(1);
  options.Add("height", o.height_px, "Of the picture").Unit("px").AtLeast(1);
  options.Add("camera", o.camera, "A camera.yaml with a plane, instead of the scene's camera");
  options.Add("radius", o.radius_mm, "Marker radius").Unit("mm").Positive();
  options.Add("radius-px", o.radius_px, "Marker radius in the picture").Unit("px").Key("radius_px").Positive();
  options.Add("distance", o.distance_mm, "Camera to plane").Unit("mm").Positive();
  options.Add("yaw", o.yaw_deg, "How far the camera looks askance").Unit("degrees");
  options.Add("pitch", o.pitch_deg, "How far it looks up or down").Unit("degrees");
  options.Add("roll", o.roll_deg, "How far it is tilted").Unit("degrees");
  options.Add("distortion", o.distortion, "Of the lens").Value("K1,K2,P1,P2,K3");
  options.Add("shutter", o.shutter, "Exposure time as a part of the frame time");
  options.Add("readout", o.readout_s, "In which a rolling shutter reads the picture from top to bottom").Unit("s");
  options.Add("psf", o.psf_px, "Standard deviation of the point-spread").Unit("px");
  options.Add("read-noise", o.read_noise, "Standard deviation, grey values");
  options.Add("shot-gain", o.shot_gain, "Variance per grey value of level");
  options.Add("start", o.start_s, "Time stamp of the first frame").Unit("s");
  options.Add("jitter", o.jitter, "Time stamps vary by up to this part of the frame time");
}

// MARKER=START_S,LENGTH_S
Occlusion OcclusionOf(const std::string& text, const std::string& said) {
  const auto [marker, numbers] = SplitNameValue(said, text);
  const std::vector<double> times = ParseNumbers(numbers, 2, said);
  return {marker, times[0], times[1]};
}

void DescribeRoom(SynthRunOptions& o, OptionList& options) {
  const OptionList::Choices<SynthRunOptions::Markers> kinds = {{"disc", SynthRunOptions::Markers::kDisc},
                                                               {"led", SynthRunOptions::Markers::kLed},
                                                               {"aruco", SynthRunOptions::Markers::kAruco}};
  options.AddChoice("markers", o.markers, kinds, "Discs, lights of different colours in a colour video, or squares");
  options.Add("depth", o.depth_mm, "Markers that stand proud of the plane, and how far")
      .Unit("mm")
      .Value("NAME=MM")
      .Repeats();
  options.Add("level", o.level, "Grey level of the markers; above 255 they saturate");
  options.Add("brightness", o.brightness, "Factor on everything but the markers");
  options.Add("bright-room", o.bright_room, "Light wall and clothes, dark markers");
  options.Add("exposure", o.exposure, "Factor on everything");
  options.Add("flicker", o.flicker, "Amplitude of the changes in brightness");
  options.Add("reflections", o.reflections, "Number of fixed reflections").AtLeast(0);
  options.Add("glint", o.glint, "A moving reflection");
  options
      .AddCustom("hide", "A hand hides this marker from this time on, for so long",
                 [&o](const OptionTexts& texts, const std::string& said) {
                   o.occlusions.clear();
                   for (const std::string& text : texts) o.occlusions.push_back(OcclusionOf(text, said));
                 })
      .Unit("s")
      .Value("NAME=START_S,LENGTH_S")
      .Repeats();
  options.Add("color", o.colour, "A colour video");
}

template <typename T>
void Take(const std::optional<T>& given, T& value) {
  if (given) value = *given;
}

void TakeWalk(const SynthRunOptions& o, SceneOptions& scene) {
  const bool is_drawn = o.drawn == SynthRunOptions::Drawn::kWalking;
  if (!is_drawn && !o.stride_s && !o.treadmill && !o.passes) return;
  if (is_drawn && (scene.motion_file || !o.motion_table.empty()))
    throw UsageError("--movement walking draws a walk, and --motion has a recorded one: leave --movement out");
  if (!is_drawn && !scene.motion_file)
    throw UsageError("--stride, --treadmill and --passes need a walk: --movement walking, or one recorded in --motion");
  WalkOptions& walk = scene.walk.emplace();
  Take(o.repetitions, walk.strides);
  Take(o.passes, walk.passes);
  Take(o.rest_s, walk.pause_s);
  Take(o.stride_s, is_drawn ? walk.drawn.stride_s : walk.stride_s);
  Take(o.stride_mm, walk.drawn.stride_mm);
  // Whoever is to walk for so long does not stop before.
  const double stride_s = is_drawn ? walk.drawn.stride_s : walk.stride_s;
  if (o.duration_s && !o.repetitions && stride_s > 0)
    walk.strides = static_cast<int>(std::ceil(*o.duration_s / (stride_s * walk.passes)));
  walk.drawn_markers = o.motion.extra_markers;
  walk.is_treadmill = o.treadmill;
  if (o.repetitions && !is_drawn && !o.stride_s)
    throw UsageError("--repetitions: of a recorded walk needs --stride, the duration of the stride that is repeated");
}

void TakeMotion(const SynthRunOptions& o, SceneOptions& scene) {
  StsMotionOptions& motion = scene.motion;
  Take(o.motion_seed, motion.seed);
  Take(o.repetitions, motion.repetitions);
  Take(o.pace, motion.pace);
  Take(o.rest_s, motion.max_rest_s);
  motion.min_rest_s = std::min(motion.min_rest_s, motion.max_rest_s);
  motion.facing = o.facing;
  motion.start_standing = o.standing;
  motion.time_warp = o.warp;
  motion.skin_mm = o.skin_mm;
  if (o.still) motion.ankle_sway_mm = motion.body_sway_deg = 0;
  if (o.exo_knee_mm) motion.exo_knee_mm = Eigen::Vector2d((*o.exo_knee_mm)[0], (*o.exo_knee_mm)[1]);
  const bool is_drawn_rise = o.motion.file.empty() && o.drawn == SynthRunOptions::Drawn::kSitToStand;
  if (is_drawn_rise) motion.extra_markers = o.motion.extra_markers;
  scene.motion_table = o.motion_table;
  scene.mirror_table = !o.motion_table.empty() && o.facing == motion::Facing::kLeft;
  if (!o.motion.file.empty()) {
    scene.motion_file = o.motion;
    scene.motion_file->facing = o.facing;
  }
  TakeWalk(o, scene);
  if (o.repetitions || scene.walk || !o.motion_table.empty() || scene.motion_file) scene.duration_s = 0;
}

void TakeCamera(const SynthRunOptions& o, SceneOptions& scene) {
  Take(o.duration_s, scene.duration_s);
  Take(o.rate_hz, scene.frame_rate_hz);
  Take(o.width_px, scene.width_px);
  Take(o.height_px, scene.height_px);
  Take(o.radius_px, scene.marker_radius_px);
  Take(o.radius_mm, scene.marker_radius_mm);
  Take(o.distance_mm, scene.distance_mm);
  Take(o.yaw_deg, scene.yaw_deg);
  Take(o.pitch_deg, scene.pitch_deg);
  Take(o.roll_deg, scene.roll_deg);
  Take(o.distortion, scene.distortion);
  Take(o.shutter, scene.shutter);
  Take(o.readout_s, scene.readout_s);
  Take(o.psf_px, scene.psf_sigma_px);
  Take(o.read_noise, scene.noise.read_sd);
  Take(o.shot_gain, scene.noise.gain);
  scene.start_s = o.start_s;
  scene.time_jitter = o.jitter;
  if (o.camera.empty()) return;
  scene.camera = camera::ReadCameraProfile(o.camera);
  if (!scene.camera->camera_from_plane)
    throw UsageError("{}: has no plane; a scene needs plane_rvec and plane_tvec", o.camera.string());
}

void TakeRoom(const SynthRunOptions& o, SceneOptions& scene) {
  constexpr double kDarkMarker = 18;
  Take(o.brightness, scene.brightness);
  Take(o.exposure, scene.exposure);
  Take(o.flicker, scene.flicker);
  Take(o.reflections, scene.reflections);
  scene.marker_level = o.level.value_or(o.bright_room ? kDarkMarker : scene.marker_level);
  scene.glint = scene.glint || o.glint;
  scene.exoskeleton = o.exoskeleton;
  scene.hub_mm = o.hub_mm;
  scene.bright_room = o.bright_room;
  if (o.markers == SynthRunOptions::Markers::kAruco) scene.marker_kind = MarkerKind::kAruco;
  const bool is_led = o.markers == SynthRunOptions::Markers::kLed;
  scene.colour = o.colour || is_led;
  if (is_led) scene.marker_bgr = LedColours();
  scene.occlusions.insert(scene.occlusions.end(), o.occlusions.begin(), o.occlusions.end());
  for (const auto& [marker, depth_mm] : o.depth_mm) scene.marker_depth_mm[marker] = depth_mm;
}

SceneOptions SceneOf(const SynthRunOptions& o) {
  SceneOptions scene = o.scene == SynthRunOptions::Scene::kHard ? HardScene(o.seed) : CleanScene(o.seed);
  TakeMotion(o, scene);
  TakeCamera(o, scene);
  TakeRoom(o, scene);
  return scene;
}

// With whoever walks in or stands beside; the camera stays where it is without them.
Scene StagedScene(const SynthRunOptions& o) {
  SceneOptions options = SceneOf(o);
  if (!o.walk_in_s && !o.second_person_mm) return Scene(options);
  if (!options.motion_table.empty() || options.motion_file || options.walk)
    throw UsageError("--walk-in, --second-person: not with --motion-table, --motion or a walk");
  options.camera = Scene(options).Profile();
  std::shared_ptr<const MarkerMotion> motion = std::make_shared<StsMotion>(options.motion);
  if (o.walk_in_s) {
    motion = MakeWalkIn(motion, *o.walk_in_s);
    if (options.duration_s > 0) options.duration_s += *o.walk_in_s;
  }
  if (o.second_person_mm) {
    StsMotionOptions other = options.motion;
    ++other.seed;
    motion = MakeTwoPeople(motion, std::make_shared<StsMotion>(other), *o.second_person_mm);
  }
  return Scene(options, motion);
}

Json RenderPopulation(const SynthRunOptions& o, Run& run) {
  PopulationOptions population{.seed = o.seed, .people = *o.people, .sessions = o.sessions};
  const SceneOptions scene = SceneOf(o);
  const std::vector<Session> sessions = DrawPopulation(population, scene.motion);
  std::vector<std::string> names = {"participants.tsv", "participants.json", "cohort.yaml", "truth.csv"};
  for (const Session& session : sessions)
    for (const char* trial : {"human", "exo"})
      for (const char* file : {"video.mp4", "truth.csv", "camera.yaml", "scene.json"})
        names.push_back((session.Folder() / trial / file).string());
  run.Begin(names);
  WritePopulation(sessions, scene, run.Place());
  run.Report("{} people, {} sessions each\n", population.people, population.sessions);
  return {{"people", population.people}, {"sessions", population.sessions}};
}

Json RenderRecording(const SynthRunOptions& o, Run& run) {
  const Scene scene = StagedScene(o);
  RecordingOptions recording{.crf = o.crf.value_or(o.scene == SynthRunOptions::Scene::kHard ? 23 : 17),
                             .lossless = o.lossless,
                             .pictures = o.pictures,
                             .quiet = run.Quiet()};
  std::vector<std::string> names = {"truth.csv", "camera.yaml", "scene.json"};
  if (!o.pictures) names.push_back("video.mp4");
  for (int frame = 0; o.pictures && frame < scene.Frames(); ++frame)
    names.push_back(fmt::format("frames/{:05d}.png", frame));
  run.Begin(names);
  const RecordingSummary written = WriteRecording(scene, run.Place(), recording);
  const std::string video = run.Folder() / (o.pictures ? "frames/%05d.png" : "video.mp4");
  Json results = {{"video", video}, {"frames", written.frames}};
  std::string hidden;
  for (std::size_t m = 0; m < written.markers.size(); ++m) {
    const auto frames = written.hidden_frames[m];
    results["hidden_frames"][written.markers[m]] = frames;
    if (frames > 0) hidden += fmt::format(", {} hidden in {}", written.markers[m], frames);
  }
  run.Report("{}{}: {}\n", Counted(written.frames, "frame"), hidden, video);
  return results;
}

}  // namespace

void Describe(SynthRunOptions& o, OptionList& options) {
  const OptionList::Choices<SynthRunOptions::Scene> scenes = {{"clean", SynthRunOptions::Scene::kClean},
                                                              {"hard", SynthRunOptions::Scene::kHard}};
  options.AddChoice("scene", o.scene, scenes, "720p60, or 1080p60, oblique, blurred, with reflections and hands");
  options.Add("seed-number", o.seed, "Random seed");
  DescribeMotion(o, options);
  DescribeCamera(o, options);
  DescribeRoom(o, options);
  options.Add("crf", o.crf, "H.264 quality, 17 (fine) to 28 (coarse)").Between(0, 51).Otherwise("17 clean, 23 hard");
  options.Add("lossless", o.lossless, "Keep every grey value");
  options
      .Add("population", o.people,
           "A cohort for lake cohort instead: so many people, drawn at random, with and without exoskeleton")
      .AtLeast(1);
  options.Add("sessions", o.sessions, "With --population: sessions of each").AtLeast(1);
  options.Add("pictures", o.pictures, "frames/00000.png … instead of a video");
}

std::string NameOf(const SynthRunOptions& options) {
  return fmt::format("{}-{}", options.scene == SynthRunOptions::Scene::kHard ? "hard" : "clean", options.seed);
}

Json RunSynth(const SynthRunOptions& options, Run& run) {
  for (const auto& [file, role] :
       {std::pair{options.motion_table, "motion table"}, {options.motion.file, "motion"}, {options.camera, "camera"}})
    if (!file.empty()) run.AddInput(file, role);
  return options.people ? RenderPopulation(options, run) : RenderRecording(options, run);
}

}  // namespace lake::synth
