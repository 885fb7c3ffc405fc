// From a video to marker tracks.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/core/options.h"
#include "lake/core/progress.h"
#include "lake/motion/marker_recording.h"
#include "lake/tracking/candidates.h"
#include "lake/tracking/frame_times.h"
#include "lake/tracking/marker_detector.h"
#include "lake/tracking/naming.h"
#include "lake/tracking/recording_quality.h"
#include "lake/tracking/sigma_calibration.h"
#include "lake/video/video_reader.h"

namespace lake::tracking {

struct TrackOptions {
  std::vector<std::string> names = {kLegMarkers.begin(), kLegMarkers.end()};
  std::vector<MarkerSeed> seeds;
  std::string detector = "reflective";  // one of DetectorNames()
  Polarity polarity = Polarity::kBright;
  std::vector<std::string> colors;         // as ParseMarkerColor reads them, one for all or one per name
  std::string dictionary = "DICT_4X4_50";  // ArUco; ids 0, 1, … are the names in order
  cv::Rect crop;                           // px; empty: the whole picture
  video::VideoReaderOptions reader;        // start, end, rates
  std::function<Eigen::Vector2d(const Eigen::Vector2d&)> metric_from_px = [](const Eigen::Vector2d& px) { return px; };
  Eigen::Vector2d up_px = {0, -1};
  std::vector<Eigen::Vector2d> other_ups_px;  // which way is up may also be one of these: as the leg shows
  MarkerPhysics physics;
  bool quiet = false;  // no progress

  // Throws UsageError naming the option that cannot be: a bad or repeated name, a seed for no name, colours that do not
  // match, physics that is not positive.
  void Check() const;
};

// With the reader's.
void Describe(TrackOptions& o, OptionList& options);
void DescribeNames(std::vector<std::string>& names, std::vector<MarkerSeed>& seeds, OptionList& options);
Option& DescribePolarity(Polarity& polarity, OptionList& options);
Option& DescribeCrop(cv::Rect& crop, OptionList& options);

struct TrackResult {
  motion::MarkerRecording recording;  // px; detected or missing; times corrected as `times` says
  video::VideoInfo video;
  std::size_t tracklets = 0;  // objects followed, named or not
  double radius_px = 0;       // median over what was followed
  SigmaCalibration sigma;
  FrameTimes times;
  std::optional<MarkerFigures> figures;  // of a detector that measures blobs in the luma
  Eigen::Vector2d up_px = {0, -1};       // with which the markers were named
};

// Throws Error for pictures that are too small for a leg with markers in them.
void CheckPictureSize(const std::filesystem::path& video, const video::VideoInfo& info);

// Decoding runs ahead in its own threads. Throws Error on a video that cannot be read, is interlaced or of fewer than
// two frames; NamingError where fewer markers than names are seen, or they cannot be named with certainty.
TrackResult TrackMarkers(const std::filesystem::path& video, const TrackOptions& options);

// The kinds of markers, as options.detector names them.
std::vector<std::string> DetectorNames();

// Makes what measures a marker near a click as TrackMarkers does; empty for a kind that cannot. Throws Error where the
// film does not show what the options name.
DetectorMaker ClickDetector(const std::filesystem::path& video, const TrackOptions& options);

// What a NamingError would list: all that is found, without naming it.
CandidateList FindCandidates(const std::filesystem::path& video, const TrackOptions& options);

}  // namespace lake::tracking
