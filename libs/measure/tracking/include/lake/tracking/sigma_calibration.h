// What a video's compression does to the positions, found from the positions themselves.
#pragma once

#include "lake/motion/marker_recording.h"
#include "lake/video/video_reader.h"

namespace lake::tracking {

struct SigmaCalibration {
  double fit_px = 0;          // median of the fits' own sigmas, of the samples that were compared
  double scatter_px = 0;      // root mean square scatter about smooth motion, per axis
  double compression_px = 0;  // what is added to the fits' sigmas, in quadrature; of all fast samples
  // Of the sigmas' squares: errors that stay alike for some frames, so that a smooth path follows them as it does
  // movement. Found of a person's markers; those of what holds still at rest have it in their sigmas.
  double lasting_share = 0;
};

// A fit's sigma knows the noise of its own pixels. A compressed frame is made by shifting blocks of earlier ones by
// quarter pixels, which displaces a marker without leaving a trace in its picture. What is added to the fits' sigmas in
// quadrature, per marker, to those of detected samples:
// - Of markers that hold still at rest (a mechanism's): what the moving ones scatter about a smooth path (the residual
//   of a local fourth-degree polynomial in time, Savitzky & Golay 1964), times how much larger than that the errors are
//   which last for some frames, by windows twice as wide; less at rest, where the displacement is frozen.
// - Of a person's: a power of what the likelihood of white jerk (lake::dynamics) leaves to the measurement, which
//   includes the skin's tremor, and of the bits per pixel, as found in rendered recordings of each codec; 0.7 of it
//   lasts for some frames.
// Without compression nothing is added. `recording`: of at least 60 samples, or nothing is found.
SigmaCalibration CalibrateSigmas(const video::VideoInfo& video, motion::MarkerRecording& recording);

// The usual error of a person's markers in such a film, in the fits' sigmas.
double UsualErrorOverFit(const video::VideoInfo& video);

}  // namespace lake::tracking
