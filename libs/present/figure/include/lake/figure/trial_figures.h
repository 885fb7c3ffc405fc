// Figures of one trial and of what is compared with it: PNG or SVG by the extension. All throw Error if they cannot be
// drawn.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/axis/functional_axis.h"
#include "lake/compare/symmetry.h"
#include "lake/gait/gait_cycles.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/marker_measures.h"
#include "lake/sync/align.h"

namespace lake::figure {

// Another program's knee angle in the same frames; none where it is empty.
struct OtherAngle {
  std::string name = {};
  std::vector<double> angle_deg = {};
};

// Left: the paths in the leg frame's axes, with the leg at a few moments of the first repetition; right: the knee angle
// with the markers' own angle frame by frame, then the difference of the two with the band of ± 2 SD. Events are
// vertical lines; frames in which ankle, knee or hip was not seen are shaded.
void DrawLegFigure(const std::filesystem::path& path, const gait::LegFitResult& result, const OtherAngle& other = {});

// Markers that are no leg, over time.
void DrawTracksFigure(const std::filesystem::path& path, const motion::MarkerRecording& recording,
                      const std::string& title);

// Of --angle, --distance and --speed the first six over time with their ± 2 SD, one above the other.
void DrawMeasures(const std::filesystem::path& path, const motion::MarkerRecording& recording,
                  const std::vector<gait::MeasuredCourse>& courses);

// Knee, ankle (where it is known), thigh and shank over 0 to 100 % of the gait cycle: each stride thin, their mean with
// a band of ± 1 SD over strides, toe-off as a line, from quiet standing where that is known; behind the knee the
// reference's band.
void DrawGaitCycles(const std::filesystem::path& path, const gait::LegFitResult& leg,
                    const gait::Measures<gait::GaitCycle>& cycles,
                    const std::optional<gait::ReferenceCurve>& reference = {});

// A signal of one recording and its prediction from the other, the likelihood of each offset, the parts' departures.
void DrawSync(const std::filesystem::path& path, const sync::Alignment& alignment, const std::string& title);

// Both knees over the rise with the interval of their difference, the symmetry index of each quantity.
void DrawSymmetry(const std::filesystem::path& path, const compare::Symmetry& symmetry);

// Where the axis is on the shank, seen along it: windows and whole with their 95 % ellipses, and where the axis is
// frame by frame; beside it, that over the knee angle with its 95 % band.
void DrawAxis(const std::filesystem::path& path, const axis::SegmentMotion& motion, const axis::MeanAxesResult& axes,
              const std::vector<axis::InstantaneousCentre>& centres);

}  // namespace lake::figure
