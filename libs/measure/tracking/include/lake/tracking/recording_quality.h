// What a recording is worth for tracking: figures of its markers, its pictures and its time stamps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lake/tracking/marker_detector.h"
#include "lake/tracking/naming.h"
#include "lake/tracking/tracklet.h"
#include "lake/video/video_reader.h"

namespace lake::tracking {

// Of the markers that were named; medians over all their samples unless said otherwise. Lengths in px, levels in
// grey levels.
struct MarkerFigures {
  std::size_t samples = 0;
  double radius_px = 0;
  double contrast = 0;                     // above what is round them
  double noise = 0;                        // standard deviation of a pixel as bright as a marker
  double contrast_over_noise = 0;          // of the faintest tenth of the samples
  double saturated_share = 0;              // of the samples, those of markers as bright as the video can be
  double sigma_px = 0;                     // root mean square of what the fits state, per axis
  double fastest_px = 0;                   // per frame, 98 % quantile
  std::optional<double> shutter_fraction;  // of the frame time; unknown where nothing moves fast
  double blur_px = 0;                      // of the fastest, during the exposure (half a frame where it is not known)
};

MarkerFigures FiguresOf(std::span<const Tracklet* const> markers, const ImageFigures& image,
                        const video::VideoInfo& video);

struct RecordingCheckOptions {
  std::vector<std::string> names = {kLegMarkers.begin(), kLegMarkers.end()};  // ankle and hip are among them
  std::vector<MarkerSeed> seeds;
  Polarity polarity = Polarity::kBright;
  cv::Rect crop;  // px; empty: the whole picture
  video::VideoReaderOptions reader;
  // Of pictures to decode, some 3.5 s of one core for 1080p; then only middle and end are still seen. No limit in
  // seconds: what is said of a recording must not depend on the machine.
  double budget_mpx = 2000;
  int runs = 8;             // places over the whole file, …
  int frames_per_run = 30;  // … each of so many neighbouring frames
  int frames_named = 600;   // at least, from the beginning, as far as the recording goes: in which markers are named
};

// A bright spot in the frame that is shown.
struct CheckedSpot {
  Eigen::Vector2d position;  // px
  double radius_px = 0;
  double contrast = 0;
  std::string name;  // of the marker that it is; empty: another
};

struct RecordingCheck {
  video::VideoInfo video;           // its bits per pixel: of the frames in which the markers were named, if they were
  std::int64_t frames_in_file = 0;  // from the container's stamps; 0 where it does not say
  int frames_seen = 0, places_seen = 0;

  // Why the markers cannot be named as TrackMarkers does it; empty if they were, and only then what depends
  // on them is known: `markers`, `compression_px` to `segment_px`, `knee_sd_deg`.
  std::string why_not_named = "not looked for";
  double all_seen_share = 0;     // of the frames: every named marker; without names, as many spots as there are markers
  double knee_hidden_share = 0;  // of the frames; 1 where no marker has its name
  double spots = 0;              // marker-like detections in a frame, median
  double clutter = 0;            // of these, more than there are markers
  double strongest_clutter = 0;  // its contrast over the faintest marker's
  MarkerFigures markers;
  double compression_px = 0;  // that coding adds to a position's error
  double position_sd_px = 0;  // of one frame, per axis, with it
  double segment_px = 0;      // mean of shank and thigh
  double travel_px = 0;    // how far the paths reach, the farthest marker's; without names, the farthest bright spot's
  double knee_sd_deg = 0;  // expected of one frame's knee angle
  // Of a person whose foot travels: how many whole strides are in view, from turn to turn of the ankle about the hip.
  std::optional<int> strides;

  double flicker = 0;               // brightness from frame to frame, relative standard deviation
  int repeated_frames = 0;          // of those seen
  std::int64_t dropped_frames = 0;  // of the whole file, by its stamps
  std::optional<double> tilt_deg;   // clockwise; of what should stand upright in the room, where enough of it is seen

  bool IsNamed() const { return why_not_named.empty(); }

  std::int64_t shown_frame_ms = 0;  // when the frame that is shown was
  cv::Mat frame;                    // CV_8UC1
  std::vector<CheckedSpot> spots_shown;
  double seconds = 0;
};

// How many frames are missing where two stamps are farther apart than one and a half of the median interval.
std::int64_t DroppedFrames(const std::vector<double>& stamps_s);

// Looks into the recording at places over its whole length, as far as `budget_mpx` goes, and names the leg's markers as
// TrackMarkers does in as much of its beginning. Throws Error as VideoReader does.
RecordingCheck CheckRecording(const std::filesystem::path& video, const RecordingCheckOptions& options = {});

}  // namespace lake::tracking
