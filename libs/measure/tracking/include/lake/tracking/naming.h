// Which tracklet is which marker.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/motion/marker_recording.h"
#include "lake/tracking/marker_detector.h"
#include "lake/tracking/marker_physics.h"
#include "lake/tracking/tracklet.h"

namespace lake::tracking {

// The markers of the leg, from the ground up.
inline constexpr std::array<std::string_view, 4> kLegMarkers = {"ankle", "knee", "hip", "waist"};

struct NamingOptions {
  std::vector<std::string> names;
  std::vector<MarkerSeed> seeds;
  // Identity of a tracklet (colour, patch) for each name, if the detector knows identities; empty otherwise.
  std::vector<int> identities;
  // Where distances are what they are: the sagittal plane if it is calibrated, else the image itself.
  std::function<Eigen::Vector2d(const Eigen::Vector2d&)> metric_from_px = [](const Eigen::Vector2d& px) { return px; };
  Eigen::Vector2d up_px = {0, -1};  // the direction of a plumb line in the image, upwards
  MarkerPhysics physics;
  // Frames before which time may be missing from the recording: a marker may then have come as far as it ever does.
  std::vector<std::int64_t> discontinuities = {};
  std::vector<std::int64_t> repeated = {};  // frames that may show the picture before once more, increasing
  Eigen::AlignedBox2d picture = {};         // in px: beyond it nothing is seen; empty: not known
  int rotate_deg = 0;  // by which the pictures were turned clockwise already, for what a message advises
};

// Gives each name its samples over all frames: `recording` holds the frames and their times, its markers are filled in.
//
// A name is anchored to one tracklet: by its seed; by its identity; or, for the leg, as the chain
// ankle–knee–hip(–waist) whose neighbouring distances stay most nearly constant while the knee flexes, whose ankle
// moves least, and which stands upright in that order. Further tracklets join where their distances to the neighbours,
// their place and their size agree. Throws Error, naming the candidates and how to seed them, when no chain is found,
// when another is nearly as good, when a seed has no marker near it, or when fewer markers than names are there.
void NameTracklets(const std::vector<Tracklet>& tracklets, const NamingOptions& options,
                   motion::MarkerRecording& recording);

}  // namespace lake::tracking
