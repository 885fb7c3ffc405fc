// The parameters of a rendering.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <string>
#include <vector>

#include "lake/camera/camera.h"
#include "lake/core/json.h"
#include "lake/synth/motion_file.h"
#include "lake/synth/noise.h"
#include "lake/synth/sts_motion.h"
#include "lake/synth/walk_motion.h"

namespace lake::synth {

enum class MarkerKind { kDisc, kAruco };

// A hand that reaches over one marker and withdraws.
struct Occlusion {
  std::string marker;
  double start_s = 0;  // after the first frame: when the marker begins to count as hidden (about; truth says exactly)
  double hidden_s = 0.3;
};

// Levels are grey values of the exposed picture: 255 is where the sensor saturates; higher ones are allowed.
struct SceneOptions {
  std::uint64_t seed = 1;  // of all random parameters here; the motion has its own

  // --- what moves ---
  StsMotionOptions motion;
  std::filesystem::path motion_table;  // a recorded motion instead (see ReadMotionTable)
  bool mirror_table = false;
  std::optional<MotionFile> motion_file;  // or a person's in space
  std::optional<WalkOptions> walk;        // a walk, of the motion file or drawn (facing as the motion's)

  // --- time: a frame's time stamp is the middle of its exposure ---
  double frame_rate_hz = 60;
  double duration_s = 0;   // 0: as long as the motion; beyond its end the last pose is held
  double start_s = 0;      // time stamp of the first frame, at which the motion begins
  double time_jitter = 0;  // time stamps are moved by up to ± this part of the frame time (variable frame rate)
  double shutter = 0.3;    // exposure time as a part of the frame time
  double readout_s = 0;    // rolling shutter: a marker in row y is exposed (y / height − 1/2) readout_s later

  // --- camera ---
  int width_px = 1280, height_px = 720;
  double marker_radius_mm = 7.25;  // a 14.5 mm ball, as in motion laboratories
  double marker_radius_px = 4;     // sets the focal length
  double distance_mm = 3500;
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;  // how far the camera stands off the normal of the sagittal plane
  std::array<double, 5> distortion = {};            // k1 k2 p1 p2 k3
  std::optional<camera::CameraProfile> camera;      // instead of all of this; must have a plane

  // --- markers ---
  MarkerKind marker_kind = MarkerKind::kDisc;
  double marker_level = 235;
  std::map<std::string, cv::Vec3f> marker_bgr;    // levels of single markers in a colour picture
  std::map<std::string, double> marker_depth_mm;  // how far single markers stand proud of the plane, towards the camera
  double aruco_mm = 60;  // side of an ArUco marker's black square; dictionary 4X4_50, id = order of the names

  // --- the room ---
  bool colour = false;           // BGR pictures instead of grey ones
  bool room = true;              // wall, floor, furniture; otherwise an even background
  bool body = true;              // clothed leg, trunk, shoe
  double background_level = 40;  // of the even background
  double brightness = 1;         // factor on everything but the markers
  bool bright_room = false;      // light wall and clothes, for dark markers
  bool exoskeleton = false;      // grey links beside the leg, their joint at exo_knee
  double hub_mm = 0;             // radius of an opaque disc at exo_knee; 0: none
  int reflections = 0;           // fixed bright discs and streaks, clear of the markers' paths
  bool glint = false;            // a moving, elongated spot of changing brightness
  std::vector<Occlusion> occlusions;

  // --- image formation ---
  double psf_sigma_px = 0.7;  // Gaussian point-spread
  double exposure = 1;        // factor on everything
  double flicker = 0;         // amplitude of a sinusoid in brightness; a quarter of it more is drawn for every frame
  SensorNoise noise;

  // Throws UsageError naming the option.
  void Check() const;
};

// 720p60, radius 4 px, noise 1–2 grey values, 10 s, two rises; meant for CRF 17.
SceneOptions CleanScene(std::uint64_t seed);

// 1080p60, radius 6 px, oblique camera with distortion, shutter 0.7, flicker 3 %, four reflections, a glint, three
// occlusions of 8–26 frames, saturated markers, 10 s; meant for CRF 23.
SceneOptions HardScene(std::uint64_t seed);

// Red hip, green knee, blue ankle, yellow waist and toe, magenta exo_knee: levels for a colour picture.
std::map<std::string, cv::Vec3f> LedColours();

Json ToJson(const SceneOptions& options);

}  // namespace lake::synth
