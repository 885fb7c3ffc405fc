// Walking: heel strikes and toe-offs from markers. Heel strike is where the foot's downward velocity is largest,
// toe-off where its upward velocity is (O'Connor et al. 2007, doi:10.1016/j.gaitpost.2006.05.016), combined with where
// heel or toe are farthest before or behind the hip (Zeni et al. 2008, doi:10.1016/j.gaitpost.2007.07.007).
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "lake/motion/leg_motion.h"

namespace lake::gait {

struct LegFitResult;

enum class Ground { kOverground, kTreadmill };

// A foot's load on a force plate: from where the vertical force rises above 20 N over what the empty plate reads to
// where it falls below, between samples (Zeni et al. 2008); NaN: it bears already when the recording begins, or still
// when it ends. Loads of less than 0.1 s, and gaps of less than 0.05 s, are the plate's noise.
struct PlateLoad {
  double begin_s = NAN, end_s = NAN;
  double begin_sd_s = NAN, end_sd_s = NAN;  // by the empty plate's noise over the force's slope, and half a sample
};
// Of a plate's vertical force.
std::vector<PlateLoad> LoadsOf(const std::vector<double>& force_n, const std::vector<double>& time_s);

struct PlateContact : PlateLoad {
  std::string plate = {};
};

struct WalkingOptions {
  std::optional<Ground> ground;           // found from the motion
  std::optional<double> belt_speed_mm_s;  // of a treadmill; else that of the foot in stance
  // Markers beside the leg's, used where the recording has them. Heel and toe count as a pair.
  std::string heel = "heel", toe = "toe";
  std::string other_ankle = "other_ankle", other_heel = "other_heel", other_toe = "other_toe";
  std::vector<PlateContact> contacts = {};  // their events win over the markers'
};

// A plate's event, and by how much the markers alone show it later.
struct PlateEvent {
  motion::StsEvent event;
  double markers_later_s = NAN;  // NaN: they show none within 0.15 s
};

struct Walk {
  // In the order of time, each with its standard deviation. `repetition` counts the heel strikes of the measured leg
  // from 1 (0 before the first) and leaves a number out where the walk is interrupted: a stride is complete exactly
  // where the heel strikes of its number and of the next are here.
  std::vector<motion::StsEvent> events;
  Ground ground = Ground::kOverground;
  bool by_foot = false;  // some event is from heel and toe, not from the ankle alone
  std::vector<PlateEvent> by_plate = {};
  int strides = 0;     // complete ones of the measured leg
  int incomplete = 0;  // of which the recording has a part only
  // Why parts of the recording are left out, or all of it: a sentence each.
  std::vector<std::string> left_out;
};

struct Stride {
  motion::StsEvent strike, off, next;
};
// In the order of time: heel strike, toe-off and the next heel strike of the measured leg, by their numbers.
std::vector<Stride> StridesOf(const std::vector<motion::StsEvent>& events);

// Sets `strides` and `incomplete`.
void CountStrides(const std::vector<motion::StsEvent>& events, Walk& walk);

// Empty `events` where nobody walks. Lengths are compared with the leg's, so they may be px.
Walk FindWalk(const LegFitResult& leg, const WalkingOptions& options = {});

}  // namespace lake::gait
