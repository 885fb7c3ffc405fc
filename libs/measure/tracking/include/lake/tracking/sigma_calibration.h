// What a video's compression does to the positions, found from the positions themselves.
#pragma once

#include "lake/motion/marker_recording.h"

namespace lake::tracking {

struct SigmaCalibration {
  double fit_px = 0;          // root mean square of the fits' own sigmas, of the samples that were compared
  double scatter_px = 0;      // root mean square scatter about smooth motion, per axis
  double compression_px = 0;  // what is added to the fits' sigmas, in quadrature; of all fast samples
};

// A fit's sigma knows the noise of its own pixels. A compressed frame is made by shifting blocks of earlier ones by
// quarter pixels, which displaces a marker without leaving a trace in its picture. Of a marker that moves, it shows in
// the scatter of positions about a smooth path (the residual of a local fourth-degree polynomial in time, Savitzky &
// Golay 1964, through 0.13 s and nine samples at least); while it rests the displacement is frozen and does not show,
// though it is there. So what a marker's fast samples scatter beyond the fits' own sigma is added to all of it, less to
// those at rest; of a marker with fewer than 60 fast samples, what all markers' do. Errors that last for some frames
// are followed by a smooth path: how much larger than the scatter they are is found from the scatter in windows twice
// as wide, at 50 Hz and more. Where markers do not hold still at rest, a person's jitter scatters too: of what may be
// jitter, 0.2 mm, at most 5.5 times the fits' own sigma (root mean square) is added, and how much larger the errors are
// is taken from how large the scatter is. Without compression nothing is added. Detected samples' sigmas become
// sqrt(fit² + compression²).
SigmaCalibration CalibrateSigmas(motion::MarkerRecording& recording);

}  // namespace lake::tracking
