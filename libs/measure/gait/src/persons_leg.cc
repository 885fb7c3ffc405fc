#include "lake/gait/persons_leg.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "known_values.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/frames_where.h"
#include "lake/core/numbers.h"
#include "lake/core/uncertain_text.h"
#include "lake/gait/plausibility.h"

namespace lake::gait {
namespace {

enum Place : std::size_t { kAnkleAt, kKneeAt, kHipAt, kWaistAt };

// A value of each frame; NaN where a marker of it is not known.
std::vector<double> PerFrame(const LegPath& path, const std::function<double(std::size_t)>& value) {
  std::vector<double> values;
  for (std::size_t i = 0; i < path.frame.size(); ++i) values.push_back(value(i));
  return values;
}

Eigen::Vector3d Segment(const LegPath& path, Place below, Place above, std::size_t i) {
  return path.marker[above][i] - path.marker[below][i];
}

double LeanDeg(const LegPath& path, Place below, Place above, std::size_t i) {
  return SegmentAngleDeg(Segment(path, below, above, i).head<2>());
}

double KneeInPlaneDeg(const LegPath& path, std::size_t i) {
  return KneeAngleDeg(Segment(path, kAnkleAt, kKneeAt, i).head<2>(), Segment(path, kKneeAt, kHipAt, i).head<2>());
}

std::vector<double> LengthsOf(const LegPath& path, Place below, Place above) {
  return PerFrame(path, [&](std::size_t i) { return Segment(path, below, above, i).norm(); });
}

struct LimbLengths {
  std::vector<double> shanks, thighs;
};

// As if the person stayed at one distance from the camera: who comes nearer while walking through has all lengths grow
// with the place on the way. As they are where the hip does not travel by one and a half legs.
LimbLengths LengthsWithoutWay(const LegPath& path) {
  constexpr double kLongWay = 1.5;
  LimbLengths lengths{LengthsOf(path, kAnkleAt, kKneeAt), LengthsOf(path, kKneeAt, kHipAt)};
  auto& [shanks, thighs] = lengths;
  const std::vector<double> places = PerFrame(path, [&](std::size_t i) { return path.marker[kHipAt][i].x(); });
  std::vector<double> legs = shanks;
  for (std::size_t i = 0; i < legs.size(); ++i) legs[i] += thighs[i];
  const double leg = MedianOfKnown(legs), middle = MedianOfKnown(places);
  double products = 0, squares = 0;
  for (std::size_t i = 0; i < legs.size(); ++i) {
    if (!std::isfinite(legs[i])) continue;
    products += (places[i] - middle) * (legs[i] / leg - 1);
    squares += std::pow(places[i] - middle, 2);
  }
  if (!(QuantileOfKnown(places, 1) - QuantileOfKnown(places, 0) > kLongWay * leg)) return lengths;
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const double scale = 1 + products / squares * (places[i] - middle);
    shanks[i] /= scale;
    thighs[i] /= scale;
  }
  return lengths;
}

// 5 % to 95 % quantile over the median.
double Range(const std::vector<double>& lengths) {
  return (QuantileOfKnown(lengths, 0.95) - QuantileOfKnown(lengths, 0.05)) / MedianOfKnown(lengths);
}

// Without single frames that are far off, which the fit leaves out.
double RangeOfMost(std::vector<double> lengths) {
  constexpr double kFew = 0.2;  // of the frames
  const PlausibilityLimits limits;
  const double usual = MedianOfKnown(lengths);
  std::ptrdiff_t known = 0, far = 0;
  for (double& length : lengths) {
    if (!std::isfinite(length)) continue;
    ++known;
    if (length >= limits.shortest * usual && length <= limits.longest * usual) continue;
    ++far;
    length = kNaN;
  }
  return static_cast<double>(far) > kFew * static_cast<double>(known) ? std::numeric_limits<double>::infinity()
                                                                      : Range(lengths);
}

using Fault = std::optional<std::string>;

// A length that nobody has mostly is one in another unit.
Fault LengthFault(const char* segment, double mm, double least, double most, const LegFitOptions& options) {
  if (!std::isfinite(mm) || (mm >= least && mm <= most)) return {};
  const auto would_fit = [&](double unit) { return unit * mm >= least && unit * mm <= most; };
  const std::string unit = would_fit(kMmPerM) ? "m" : would_fit(10) ? "cm" : "";
  const std::string fault =
      fmt::format("the {} is {} mm long, not {:g} to {:g}", segment, SignificantText(mm, 3), least, most);
  constexpr double kOtherUnit = 2;  // times beyond
  const bool is_far = mm < least / kOtherUnit || mm > most * kOtherUnit;
  return fault + ": " + (is_far ? options.unit_question(unit) : "are the markers' names right?");
}

Fault LengthsFault(const LegPath& path, const LegFitOptions& options, const PersonsLegLimits& limits) {
  const auto [shanks, thighs] = LengthsWithoutWay(path);
  if (path.has_true_lengths)
    for (const auto& [lengths, below] : {std::pair{&shanks, kAnkleAt}, {&thighs, kKneeAt}})
      if (RangeOfMost(*lengths) > options.most_length_range)
        return fmt::format(
            "the distance from '{}' to '{}' changes by {:.0f} % of itself, which no limb does (at most {:.0f} %): are "
            "the markers' names right, not swapped on the way, and is the vertical ({})?",
            path.name[below], path.name[below + 1], 100 * Range(*lengths), 100 * options.most_length_range,
            options.vertical_option);
  const double shank = MedianOfKnown(shanks), thigh = MedianOfKnown(thighs);
  if (path.unit == motion::LengthUnit::kMm) {
    if (Fault fault = LengthFault("shank", shank, limits.least_shank_mm, limits.most_shank_mm, options)) return fault;
    if (Fault fault = LengthFault("thigh", thigh, limits.least_thigh_mm, limits.most_thigh_mm, options)) return fault;
  }
  if (const double ratio = thigh / shank; ratio < limits.least_ratio || ratio > limits.most_ratio)
    return fmt::format(
        "'{}' to '{}' is {:.2f} times as long as '{}' to '{}', a person's is {:g} to {:g}: are the "
        "markers' names right?",
        path.name[kKneeAt], path.name[kHipAt], ratio, path.name[kAnkleAt], path.name[kKneeAt], limits.least_ratio,
        limits.most_ratio);
  return {};
}

Fault HeightFault(const LegPath& path, const LegFitOptions& options, const PersonsLegLimits& limits) {
  const auto below = [&](Place upper, Place lower) {
    return fmt::format("'{}' lies below '{}' in most frames: are the names swapped, or the vertical wrong ({})?",
                       path.name[upper], path.name[lower], options.vertical_option);
  };
  const auto rises = PerFrame(path, [&](std::size_t i) { return Segment(path, kAnkleAt, kHipAt, i).y(); });
  if (MedianOfKnown(rises) < 0) return below(kHipAt, kAnkleAt);
  for (const auto& [lower, upper] : {std::pair{kAnkleAt, kKneeAt}, {kKneeAt, kHipAt}, {kHipAt, kWaistAt}}) {
    const auto lean = [&path, lower = lower, upper = upper](std::size_t i) {
      return std::abs(LeanDeg(path, lower, upper, i));
    };
    const auto leans = PerFrame(path, lean);
    if (MedianOfKnown(leans) > limits.most_lean_deg) return below(upper, lower);
  }
  return {};
}

Fault FacingFault(const LegPath& path, const LegFitOptions& options, const PersonsLegLimits& limits) {
  if (!path.is_facing_given) return {};
  const auto knees = PerFrame(path, [&](std::size_t i) { return KneeInPlaneDeg(path, i); });
  if (!(QuantileOfKnown(knees, 0.05) < limits.least_knee_deg)) return {};
  const std::string said = !options.said_facing.empty()           ? options.said_facing
                           : path.facing == motion::Facing::kLeft ? "--facing left"
                                                                  : "--facing right";
  return fmt::format(
      "the knee angle is {:.2f} deg at worst, a person's is above {:g} (frames {}): the knee bends backward there; the "
      "markers are not where they were taken to be, or {} is wrong",
      QuantileOfKnown(knees, 0), limits.least_knee_deg,
      FramesWhere(
          path.frame, [&](std::size_t i) { return knees[i] < limits.least_knee_deg; }, 6),
      said);
}

// How much the knee bends to the side where it is straight in the sagittal plane, and the marker that is farthest
// aside.
struct Sideways {
  double deg = 0;
  Place farthest = kKneeAt;
};

Sideways SidewaysOf(const LegPath& path) {
  constexpr double kStraightest = 0.1, kStraight_deg = 40;
  const auto bends = PerFrame(path, [&](std::size_t i) { return std::abs(KneeInPlaneDeg(path, i)); });
  const double most_deg = std::min(kStraight_deg, QuantileOfKnown(bends, kStraightest));
  const auto median = [&](const std::function<double(std::size_t)>& value) {
    return MedianOfKnown(PerFrame(path, [&](std::size_t i) { return bends[i] <= most_deg ? value(i) : kNaN; }));
  };
  const auto aside_deg = [&](Place below, Place above, std::size_t i) {
    const Eigen::Vector3d segment = Segment(path, below, above, i);
    return DegreesFromRadians(std::atan2(segment.z(), segment.head<2>().norm()));
  };
  Sideways sideways;
  sideways.deg =
      std::abs(median([&](std::size_t i) { return aside_deg(kAnkleAt, kKneeAt, i) - aside_deg(kKneeAt, kHipAt, i); }));
  std::array<std::pair<double, Place>, 3> lateral;
  for (const Place place : {kAnkleAt, kKneeAt, kHipAt})
    lateral[place] = {median([&](std::size_t i) { return path.marker[place][i].z(); }), place};
  std::sort(lateral.begin(), lateral.end());
  const bool is_last = lateral[2].first - lateral[1].first > lateral[1].first - lateral[0].first;
  sideways.farthest = lateral[is_last ? 2 : 0].second;
  return sideways;
}

std::string SidewaysText(const LegPath& path, const Sideways& sideways) {
  return fmt::format("the knee bends to the side by {:.0f}° where it is straight: is '{}' of the other leg?",
                     sideways.deg, path.name[sideways.farthest]);
}

// At the events of one kind, the median.
double MedianAt(const LegPath& path, const std::vector<motion::StsEvent>& events, motion::StsEventKind kind,
                const std::function<double(std::size_t)>& value) {
  std::vector<double> values;
  for (const motion::StsEvent& event : events) {
    const auto at = std::lower_bound(path.frame.begin(), path.frame.end(), event.frame);
    if (event.kind == kind && at != path.frame.end())
      values.push_back(value(static_cast<std::size_t>(at - path.frame.begin())));
  }
  return MedianOfKnown(std::move(values));
}

Fault RiseFault(const LegPath& path, const std::vector<motion::StsEvent>& events, const PersonsLegLimits& limits) {
  using enum motion::StsEventKind;
  const auto trunk = [&](std::size_t i) { return LeanDeg(path, kHipAt, kWaistAt, i); };
  const double shank_deg =
      MedianAt(path, events, kSeatOff, [&](std::size_t i) { return LeanDeg(path, kAnkleAt, kKneeAt, i); });
  if (std::abs(shank_deg) > limits.most_shank_deg)
    return fmt::format(
        "as a rise begins, '{}' to '{}' leans by {:.0f}°, a shank by {:g}° at most: are the markers' "
        "names a segment too high or too low?",
        path.name[kAnkleAt], path.name[kKneeAt], shank_deg, limits.most_shank_deg);
  const double knee_deg = MedianAt(path, events, kStanding, [&](std::size_t i) { return KneeInPlaneDeg(path, i); });
  if (std::abs(knee_deg) > limits.most_standing_knee_deg)
    return fmt::format(
        "the knee is bent by {:.0f}° in standing, a person's by {:g}° at most: are the markers' names "
        "right?",
        knee_deg, limits.most_standing_knee_deg);
  const double lean_deg = MedianAt(path, events, kSeatOff, trunk) - MedianAt(path, events, kStanding, trunk);
  if (lean_deg < -limits.most_backward_deg)
    return fmt::format(
        "the trunk leans backward by {:.0f}° as a rise begins, where a person leans forward: does the "
        "subject face the other way, or is '{}' wrong?",
        -lean_deg, path.name[kWaistAt]);
  return {};
}

Fault FindFault(const LegPath& path, const std::vector<motion::StsEvent>& events, const LegFitOptions& options,
                const PersonsLegLimits& limits) {
  if (Fault fault = HeightFault(path, options, limits)) return fault;
  if (const Sideways sideways = SidewaysOf(path); sideways.deg > limits.most_sideways_deg)
    return SidewaysText(path, sideways);
  if (Fault fault = LengthsFault(path, options, limits)) return fault;
  return RiseFault(path, events, limits);
}

// The exchange of two markers that makes it a leg; the one of the most constant lengths if there are several.
std::string FindExchange(const LegPath& path, const std::vector<motion::StsEvent>& events, const LegFitOptions& options,
                         const PersonsLegLimits& limits) {
  std::string exchange;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t a = kAnkleAt; a <= kWaistAt; ++a)
    for (std::size_t b = a + 1; b <= kWaistAt; ++b) {
      LegPath exchanged = path;
      std::swap(exchanged.marker[a], exchanged.marker[b]);
      const double range =
          Range(LengthsOf(exchanged, kAnkleAt, kKneeAt)) + Range(LengthsOf(exchanged, kKneeAt, kHipAt));
      if (!(range < best) || FindFault(exchanged, events, options, limits)) continue;
      best = range;
      exchange = fmt::format("; are {} and {} exchanged ({})? Then it is a person's leg", path.name[a], path.name[b],
                             options.names_option);
    }
  return exchange;
}

}  // namespace

LegPath PathOf(const motion::LegMotion& motion) {
  LegPath path;
  path.unit = motion.unit;
  path.facing = motion.facing;
  path.frame = motion.frame;
  path.has_true_lengths = false;
  for (const motion::LegSample& sample : motion.samples) {
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    path.marker[kAnkleAt].push_back(place);
    for (const auto& [at, vector] : {std::pair{kKneeAt, sample.ak}, {kHipAt, sample.kh}, {kWaistAt, sample.hw}}) {
      place.head<2>() += vector;
      path.marker[at].push_back(place);
    }
  }
  return path;
}

std::vector<UnusualLength> UnusualLengths(const LegPath& path, const LegFitOptions& options) {
  std::vector<UnusualLength> unusual;
  const LimbLengths limbs = LengthsWithoutWay(path);
  for (const Place below : {kAnkleAt, kKneeAt}) {
    const std::vector<double>& lengths = below == kAnkleAt ? limbs.shanks : limbs.thighs;
    if (const double range = RangeOfMost(lengths); range > options.usual_length_range) {
      const double usual = MedianOfKnown(lengths), allowed = options.usual_length_range / 2;
      UnusualLength& found = unusual.emplace_back();
      for (const double length : lengths) {
        const double beyond = std::abs(length / usual - 1) - allowed;
        found.angle_sigma_deg.push_back(beyond > 0 ? DegreesFromRadians(std::atan(beyond)) : 0);
      }
      found.warning = fmt::format(
          "the distance from '{}' to '{}' changes by {:.0f} % of itself, a limb's with markers on its skin by {:.0f} % "
          "at "
          "most: the knee angle's standard deviation is larger by up to {:.1f}° for it; are these points of a program "
          "without markers, or misplaced?",
          path.name[below], path.name[below + 1], 100 * range, 100 * options.usual_length_range,
          *std::ranges::max_element(found.angle_sigma_deg));
    }
  }
  return unusual;
}

std::vector<std::string> CheckPersonsLeg(const LegPath& path, const std::vector<motion::StsEvent>& events,
                                         const LegFitOptions& options, const PersonsLegLimits& limits) {
  if (const Fault fault = FacingFault(path, options, limits)) throw Fail("leg fit: {}", *fault);
  if (const Fault fault = FindFault(path, events, options, limits))
    throw Fail("leg fit: {}{}", *fault, FindExchange(path, events, options, limits));
  if (const Sideways sideways = SidewaysOf(path); sideways.deg > limits.usual_sideways_deg)
    return {SidewaysText(path, sideways)};
  return {};
}

}  // namespace lake::gait
