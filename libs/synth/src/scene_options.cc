#include "lake/synth/scene_options.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/error.h"
#include "random.h"

namespace lake::synth {
namespace {

void Require(bool good, const char* what) {
  if (!good) throw UsageError("scene: {}", what);
}

}  // namespace

void SceneOptions::Check() const {
  Require(width_px >= 16 && height_px >= 16 && width_px <= 8192 && height_px <= 8192,
          "the picture's sides must be 16 to 8192 px");
  Require(frame_rate_hz > 0 && frame_rate_hz <= 1e5, "the frame rate must be positive, at most 1e5 Hz");
  Require(duration_s >= 0 && duration_s <= 36000, "the duration must be 0 (as long as the motion) to 36000 s");
  Require(std::isfinite(start_s) && start_s >= 0, "the first time stamp must not be negative");
  Require(time_jitter >= 0 && time_jitter < 0.5, "the jitter of time stamps must be 0 to 0.5 of the frame time");
  Require(shutter >= 0 && shutter <= 1, "the shutter must be 0 to 1 of the frame time");
  Require(std::abs(readout_s) <= 0.2, "the readout must be within ±0.2 s");
  Require(marker_radius_mm > 0 && marker_radius_px > 0 && marker_radius_px < 200,
          "the marker radius must be positive, below 200 px");
  Require(distance_mm > 100, "the camera must be more than 100 mm away");
  Require(std::abs(yaw_deg) <= 60 && std::abs(pitch_deg) <= 60, "yaw and pitch must be within ±60°");
  Require(std::isfinite(roll_deg) && std::ranges::all_of(distortion, [](double k) { return std::isfinite(k); }),
          "roll and distortion must be finite");
  Require(frame_rate_hz * duration_s <= 1e7, "more than 1e7 frames; choose a shorter duration or a lower frame rate");
  Require(psf_sigma_px >= 0 && psf_sigma_px <= 10, "the point-spread must be 0 to 10 px");
  Require(exposure > 0 && brightness >= 0 && marker_level >= 0,
          "exposure must be positive, brightness and levels not negative");
  Require(flicker >= 0 && flicker < 0.5, "flicker must be 0 to 0.5");
  Require(noise.read_sd >= 0 && noise.gain >= 0, "noise must not be negative");
  Require(hub_mm >= 0 && hub_mm <= 500, "a hub's radius is 0 to 500 mm");
  Require(reflections >= 0 && reflections <= 100, "0 to 100 reflections");
  for (const Occlusion& occlusion : occlusions) Require(occlusion.hidden_s > 0, "an occlusion must last for some time");
}

SceneOptions CleanScene(std::uint64_t seed) {
  SceneOptions scene;
  scene.seed = scene.motion.seed = seed;
  scene.duration_s = 10;
  scene.motion.max_rest_s = 0.8;
  return scene;
}

SceneOptions HardScene(std::uint64_t seed) {
  SceneOptions scene = CleanScene(seed);
  scene.width_px = 1920;
  scene.height_px = 1080;
  scene.marker_radius_px = 6;
  scene.distance_mm = 2600;
  scene.shutter = 0.7;
  scene.flicker = 0.03;
  scene.reflections = 4;
  scene.glint = true;
  scene.marker_level = 280;
  scene.noise = {1.5, 0.02};
  Random random(seed, "hard scene");
  scene.yaw_deg = random.Uniform(12, 20) * (random.Uniform() < 0.5 ? -1 : 1);
  scene.pitch_deg = random.Uniform(-6, 6);
  scene.roll_deg = random.Uniform(-2, 2);
  scene.distortion = {random.Uniform(-0.20, -0.12), random.Uniform(0.02, 0.06), random.Uniform(-1e-3, 1e-3),
                      random.Uniform(-1e-3, 1e-3), 0};
  std::array<const char*, 4> markers = {"ankle", "knee", "hip", "waist"};
  for (int i = 0; i < 3; ++i) {
    std::swap(markers[i], markers[random.Integer(i, 3)]);
    const int frames = random.Integer(9, 25);  // the truth may be a frame longer or shorter
    scene.occlusions.push_back({markers[i], 1.6 + 2.8 * i + random.Uniform(0, 1.5), frames / scene.frame_rate_hz});
  }
  return scene;
}

std::map<std::string, cv::Vec3f> LedColours() {
  return {{"hip", {45, 40, 235}},    {"knee", {60, 225, 50}}, {"ankle", {240, 90, 40}},
          {"waist", {40, 220, 240}}, {"toe", {40, 220, 240}}, {"exo_knee", {225, 45, 230}}};
}

namespace {

Json MotionJson(const StsMotionOptions& m) {
  Json json = {{"seed", m.seed},
               {"facing", m.facing == motion::Facing::kRight ? "right" : "left"},
               {"repetitions", m.repetitions},
               {"start_standing", m.start_standing},
               {"shank_mm", m.shank_mm},
               {"thigh_mm", m.thigh_mm},
               {"trunk_mm", m.trunk_mm},
               {"seated_knee_deg", m.seated_knee_deg},
               {"standing_knee_deg", m.standing_knee_deg},
               {"seated_shank_deg", m.seated_shank_deg},
               {"standing_shank_deg", m.standing_shank_deg},
               {"peak_shank_deg", m.peak_shank_deg},
               {"seated_trunk_deg", m.seated_trunk_deg},
               {"standing_trunk_deg", m.standing_trunk_deg},
               {"peak_trunk_deg", m.peak_trunk_deg},
               {"rise_s", m.rise_s},
               {"descent_s", m.descent_s},
               {"min_rest_s", m.min_rest_s},
               {"max_rest_s", m.max_rest_s},
               {"variation", m.variation},
               {"ankle_sway_mm", m.ankle_sway_mm},
               {"body_sway_deg", m.body_sway_deg},
               {"skin_mm", m.skin_mm},
               {"pace", m.pace},
               {"time_warp", m.time_warp}};
  json["extra_markers"] = m.extra_markers;
  json["exo_knee_mm"] = m.exo_knee_mm ? Json{m.exo_knee_mm->x(), m.exo_knee_mm->y()} : Json();
  return json;
}

Json MotionFileJson(const MotionFile& m) {
  return {{"file", m.file.string()},
          {"map", m.reading.names},
          {"extra_markers", m.extra_markers},
          {"begin_s", m.begin_s},
          {"facing", m.facing == motion::Facing::kRight ? "right" : "left"}};
}

Json WalkJson(const SceneOptions& o) {
  const WalkOptions& w = *o.walk;
  Json json = {{"strides", w.strides},
               {"treadmill", w.is_treadmill},
               {"passes", w.passes},
               {"pause_s", w.pause_s},
               {"stride_s", o.motion_file ? w.stride_s : w.drawn.stride_s}};
  if (!o.motion_file)
    json.update(Json{{"facing", o.motion.facing == motion::Facing::kRight ? "right" : "left"},
                     {"stride_mm", w.drawn.stride_mm},
                     {"stance", w.drawn.stance},
                     {"markers", w.drawn_markers}});
  return json;
}

Json OcclusionsJson(const std::vector<Occlusion>& occlusions) {
  Json json = Json::array();
  for (const Occlusion& o : occlusions)
    json.push_back({{"marker", o.marker}, {"start_s", o.start_s}, {"hidden_s", o.hidden_s}});
  return json;
}

}  // namespace

Json ToJson(const SceneOptions& o) {
  Json json = {{"seed", o.seed}};
  if (o.motion_file)
    json["motion_file"] = MotionFileJson(*o.motion_file);
  else if (!o.motion_table.empty())
    json["motion_table"] = {{"file", o.motion_table.string()}, {"mirrored", o.mirror_table}};
  else if (!o.walk)
    json["motion"] = MotionJson(o.motion);
  if (o.walk) json["walk"] = WalkJson(o);
  json.update(Json{{"frame_rate_hz", o.frame_rate_hz},
                   {"duration_s", o.duration_s},
                   {"start_s", o.start_s},
                   {"time_jitter", o.time_jitter},
                   {"shutter", o.shutter},
                   {"readout_s", o.readout_s},
                   {"width_px", o.width_px},
                   {"height_px", o.height_px},
                   {"marker_radius_mm", o.marker_radius_mm}});
  if (!o.camera)
    json.update(Json{{"marker_radius_px", o.marker_radius_px},
                     {"distance_mm", o.distance_mm},
                     {"yaw_deg", o.yaw_deg},
                     {"pitch_deg", o.pitch_deg},
                     {"roll_deg", o.roll_deg},
                     {"distortion", o.distortion}});
  json["marker_kind"] = o.marker_kind == MarkerKind::kDisc ? "disc" : "aruco";
  json["marker_level"] = o.marker_level;
  json["marker_bgr"] = Json::object();
  for (const auto& [name, bgr] : o.marker_bgr) json["marker_bgr"][name] = {bgr[0], bgr[1], bgr[2]};
  json["marker_depth_mm"] = o.marker_depth_mm;
  json.update(Json{{"aruco_mm", o.aruco_mm},
                   {"colour", o.colour},
                   {"room", o.room},
                   {"body", o.body},
                   {"background_level", o.background_level},
                   {"brightness", o.brightness},
                   {"bright_room", o.bright_room},
                   {"exoskeleton", o.exoskeleton},
                   {"hub_mm", o.hub_mm},
                   {"reflections", o.reflections},
                   {"glint", o.glint}});
  json["occlusions"] = OcclusionsJson(o.occlusions);
  json.update(Json{{"psf_sigma_px", o.psf_sigma_px}, {"exposure", o.exposure}, {"flicker", o.flicker}});
  json["noise"] = {{"read_sd", o.noise.read_sd}, {"gain", o.noise.gain}};
  return json;
}

}  // namespace lake::synth
