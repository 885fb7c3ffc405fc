// The recording with skeleton, markers, trails and knee angle drawn on top, and each marker magnified.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/motion/leg_motion.h"
#include "lake/motion/marker_recording.h"
#include "lake/overlay/head_blur.h"
#include "lake/video/video_reader.h"

namespace lake::overlay {

// All are of one recording and belong together by frame number; frames of which they say nothing are shown as they are.
struct OverlayContent {
  const motion::MarkerRecording& tracks;                  // px
  const motion::LegMotion* motion = nullptr;              // angles and repetitions; may be absent
  const std::vector<motion::StsEvent>* events = nullptr;  // may be absent
  const motion::MarkerRecording* estimates = nullptr;     // the leg fit's, px, same frames and markers; may be absent
  const HeadBlur* anonymise = nullptr;                    // blurs the head; may be absent
  std::string note = {};                                  // a line in the panel of every frame
};

struct OverlayOptions {
  double trail_s = 1;      // how long the path of a marker stays visible
  int max_width_px = 960;  // wider videos are scaled down, 1080p quickest to its half; sides become even
  bool quiet = false;
  video::VideoReaderOptions reader = {};  // which frames, and their time; as for tracking
};

// Decodes the video again and writes H.264 in MP4 with the video's own time stamps. Marker: thin cross, open
// where the marker is = detected, dashed ring = filled, none = missing; arc: knee flexion, 0° straight, ± one standard
// deviation. Insets: each marker as it was recorded, magnified; the cross is its position, the small ring the leg fit's
// estimate, and below stand their distance and the position's standard deviation. Throws Error as VideoReader and
// VideoWriter do, and if the tracks are in mm; then there is no file.
void WriteOverlayVideo(const std::filesystem::path& video, const OverlayContent& content, const OverlayOptions& options,
                       const std::filesystem::path& out);

}  // namespace lake::overlay
