// The centre about which thigh and shank turn instead of the knee's marker, where their markers tell it.
#pragma once

#include <optional>
#include <string>

#include "lake/axis/functional_axis.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/exchange/trial.h"
#include "lake/gait/movement.h"

namespace lake::commands {

enum class KneeFrom { kMarker, kFunctional };

struct KneeOptions {
  KneeFrom knee = KneeFrom::kMarker;
  axis::SegmentMarkers segments;                    // of the person, by their names in the trials' files
  std::optional<std::filesystem::path> trial = {};  // rebuilds a knee that EXO's file hides, as learnt there
  axis::SegmentMarkers exo_segments;  // of the exoskeleton's parts, likewise; empty: its joint's marker is taken
  gait::MovementOptions movement;     // of trials whose events are to be found
};

// --segment shank=A,B --segment thigh=C,D, as an option of this name.
Option& DescribeSegments(const std::string& name, axis::SegmentMarkers& segments, const std::string& help,
                         OptionList& options);
void Describe(KneeOptions& o, OptionList& options);

// Puts the mean axis of `segments` where `marker` was in the trial's plane, frame by frame: the middle of where both
// segments carry it, missing where one of them is not seen. Returns the axis' standard deviation across it, mm, of what
// the markers show; nullopt, and the marker stays, with a warning through `run`, where the trial has none of the
// segments' markers. Throws as axis::MotionOf and MeanAxes, with the file's name.
std::optional<double> PutAxis(const axis::SegmentMarkers& segments, const std::string& marker,
                              const exchange::TrialOptions& reading, exchange::Trial& trial, Run& run);

}  // namespace lake::commands
