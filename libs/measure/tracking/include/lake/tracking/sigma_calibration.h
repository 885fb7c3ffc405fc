// What a video's compression does to the positions, found from the positions themselves.
#pragma once

#include "lake/motion/marker_recording.h"
#include "lake/video/video_reader.h"

namespace lake::tracking {

struct SigmaCalibration {
  double fit_px = 0;          // median of the fits' own sigmas, of the samples that were compared
  double scatter_px = 0;      // standard deviation of a measurement, per axis, by distances of neighbours or by paths
  double compression_px = 0;  // what is added to the fits' sigmas, in quadrature
  // Of the sigmas' squares: errors that stay alike for some frames, so that a smooth path follows them as it does
  // movement. For the leg fit; 0 of what holds still at rest, as a mechanism, whose paths are smooth.
  double lasting_share = 0;
};

// A fit's sigma knows the noise of its own pixels. A compressed frame is made by shifting blocks of earlier ones by
// quarter pixels, which displaces a marker without leaving a trace in its picture. The sigmas of detected samples get
// the usual error of a marker in such a film in quadrature: the marker's own fits' sigma times a power of what scatters
// in the distances of neighbouring markers while they move, or about their paths (what the likelihood of white jerk
// leaves to the measurement, lake::dynamics) if that is more, and a power of the bits per pixel, as found in rendered
// recordings of each codec; of a person's, 0.7 of it lasts for some frames. Without compression nothing is added.
// `recording`: of at least 60 samples, or nothing is found.
SigmaCalibration CalibrateSigmas(const video::VideoInfo& video, motion::MarkerRecording& recording);

// The usual error of markers in such a film, in the fits' sigmas.
double UsualErrorOverFit(const video::VideoInfo& video);

}  // namespace lake::tracking
