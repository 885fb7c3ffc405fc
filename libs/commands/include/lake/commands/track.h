// The work of lake-track: from a video to tracks, leg motion, figures and an annotated video.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lake/commands/further_inputs.h"
#include "lake/compare/uncertainty_budget.h"
#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/marker_measures.h"
#include "lake/gait/picture_scale.h"
#include "lake/gait/sit_to_stand.h"
#include "lake/tracking/track_markers.h"

namespace lake::commands {

// Its camera and scale bar are the picture's.
struct TrackRunOptions : gait::PictureScale, FurtherInputs {
  std::filesystem::path video;
  tracking::TrackOptions track;
  gait::LegFitOptions fit;
  std::optional<std::array<double, 4>> vertical;     // x1 y1 x2 y2 in px: both ends of a plumb line
  bool vertical_from_leg = false;                    // --vertical auto: that of the leg as it stands
  std::optional<double> readout_s;                   // rolling shutter; default: the camera file's, else 0
  std::optional<std::filesystem::path> corrections;  // frame,marker,x_px,y_px
  std::optional<std::filesystem::path> events;       // repetition,event,time_s or frame: overrule those found
  bool overlay = true;
  bool anonymise = false;                     // no face in overlay.mp4 and candidates.png
  std::vector<std::string> exports;           // as CheckExportFormats (exchange/formats.h) knows them
  bool list = false;                          // only find and draw what is there, without naming it
  gait::Person person;                        // whom the five-times test is compared with
  std::vector<gait::MarkerMeasure> measures;  // of any markers; without a leg, of two or three markers the usual ones
  compare::RecordingBudgetOptions budget;
  bool smoothed = false;  // exports hold the fit's estimates; else the measurements, with their gaps
};

void Describe(TrackRunOptions& o, OptionList& options);
std::vector<InputFile> InputsOf(const TrackRunOptions& options);

// Writes tracks, leg motion, events, figures, video and exports through `run` and returns the results for the summary.
//
// Where the markers cannot be named, candidates.png and candidates.csv show what was found, and the Error names them.
// With `list` they are all that is written.
//
// Detected samples in tracks.csv are each frame's own measurement, filled ones the fit's; trajectory.csv has the fit's
// estimates and the measurements beside them.
Json RunTrack(const TrackRunOptions& options, Run& run);

// The leg fitted to what was tracked.
struct TrackFit {
  std::optional<gait::LegFitResult> leg;  // nullopt without ankle, knee and hip among the markers
  motion::MarkerRecording tracks;         // as tracks.csv has them
  motion::MarkerRecording estimates;      // the fit's, where they lie in the picture; empty without a leg
  motion::MarkerRecording in_plane;       // what was measured, in the sagittal plane
  std::vector<std::string> warnings;
};

// What RunTrack does once the markers are tracked and corrected, without writing anything: the same detections give the
// same numbers. Throws as FitLeg does.
TrackFit FitTracked(const TrackRunOptions& options, const tracking::TrackResult& tracked);

}  // namespace lake::commands
