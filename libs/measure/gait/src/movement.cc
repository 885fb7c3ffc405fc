#include "lake/gait/movement.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/squats.h"
#include "sizes.h"

namespace lake::gait {
namespace {

using motion::StsEvent;
using motion::StsEventKind;

constexpr double kOblique_deg = 15, kLongWay = 1.5;  // the way of the hip that is needed, in shanks and thighs together
constexpr double kChange = 0.1;                      // of the lengths, where the camera's distance is not known

// The most that the projection takes from the knee's angle. A segment that leans forward also leans towards the
// camera, which sees it from where the hip is.
double LargestKneeError(const LegFitResult& leg, const motion::MarkerTrack& hip, double middle, double askance_rad) {
  double largest_deg = 0;
  for (std::size_t i = 0; i < leg.motion.samples.size(); ++i) {
    const motion::LegSample& sample = leg.motion.samples[i];
    if (!std::isfinite(sample.knee_deg) || !hip.samples[i].IsKnown()) continue;
    const double place = LegFromPlane(hip.samples[i].position, leg.motion.facing, leg.up).x() - middle,
                 seen = std::cos(askance_rad) + place / leg.sight->camera_mm.z() * std::sin(askance_rad);
    const auto error_deg = [&](double lean_deg) {
      const double lean_rad = RadiansFromDegrees(lean_deg);
      return DegreesFromRadians(std::atan2(std::sin(lean_rad) / seen, std::cos(lean_rad))) - lean_deg;
    };
    largest_deg = std::max(largest_deg, std::abs(error_deg(sample.shank_deg) - error_deg(sample.thigh_deg)));
  }
  return largest_deg;
}

// A sentence where shank and thigh, of a film or a plane's file, become longer or shorter along the way as those of a
// person do who comes nearer or goes away by 15 degrees and more: by how much, and what of the leans and of the knee's
// angle is lost. Without the camera's distance the angle is not known; then it is said of a change of 10 %.
std::optional<std::string> ObliqueWalk(const LegFitResult& leg) {
  const motion::MarkerTrack* hip = leg.trajectory.Find(leg.leg_markers.hip);
  if (!hip || leg.lateral) return std::nullopt;
  // Lengths over the place on the way, in which they are linear whatever the angle, and over the lean, which changes
  // them too.
  std::vector<double> places, lengths, leans;
  for (std::size_t i = 0; i < leg.motion.samples.size(); ++i) {
    const motion::LegSample& sample = leg.motion.samples[i];
    if (!std::isfinite(sample.knee_deg) || !hip->samples[i].IsKnown()) continue;
    places.push_back(LegFromPlane(hip->samples[i].position, leg.motion.facing, leg.up).x());
    lengths.push_back(sample.ak.norm() + sample.kh.norm());
    leans.push_back(std::pow(std::sin(RadiansFromDegrees(sample.shank_deg)), 2));
  }
  constexpr std::size_t kFewest = 8;
  if (places.size() < kFewest) return std::nullopt;
  const auto [first, last] = std::ranges::minmax(places);
  const double way = last - first, middle = (first + last) / 2;
  if (way < kLongWay * Median(lengths)) return std::nullopt;
  Eigen::MatrixX3d rows(places.size(), 3);
  for (std::size_t i = 0; i < places.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) << 1, places[i] - middle, leans[i];
  const Eigen::Vector3d fit = rows.colPivHouseholderQr().solve(
      Eigen::Map<const Eigen::VectorXd>(lengths.data(), static_cast<Eigen::Index>(lengths.size())));
  const double slope = fit.y() / fit.x(), change = std::abs(slope) * way;
  const std::string seen =
      fmt::format("the person {} while walking through: shank and thigh become {:.0f} % {} over the way",
                  slope > 0 ? "comes nearer" : "goes away", 100 * change, slope > 0 ? "longer" : "shorter");
  if (!leg.sight) {
    if (change < kChange) return std::nullopt;
    return seen +
           "; stride lengths and leans are too small; how much that takes from the knee's angle is known only with a "
           "camera that has a calibrated plane (--camera)";
  }
  const double askance_rad = std::atan(slope * leg.sight->camera_mm.z());
  if (std::abs(askance_rad) < RadiansFromDegrees(kOblique_deg)) return std::nullopt;
  return fmt::format(
      "{}, as {:.0f}° from the plane; stride lengths and speed are {:.0f} % too small, and the knee's angle is off by "
      "up to {:.0f}°; walk along the plane",
      seen, DegreesFromRadians(std::abs(askance_rad)), 100 * (1 - std::cos(askance_rad)),
      LargestKneeError(leg, *hip, middle, askance_rad));
}

std::vector<StsEvent> FoundRises(const LegFitResult& leg, const MovementOptions&, Walk&) {
  return leg.events;
}

std::vector<StsEvent> FoundSquats(const LegFitResult& leg, const MovementOptions&, Walk&) {
  return FindSquats(leg);
}

std::vector<StsEvent> FoundStrides(const LegFitResult& leg, const MovementOptions& options, Walk& walk) {
  walk = FindWalk(leg, options.walking);
  return walk.events;
}

// The hip rises while the knee extends, from a seat on which the body is not balanced over the feet; the foot turns
// before and behind the hip, and is higher while it is carried forward; the hip goes down and up again while the body
// is balanced over feet that stay.
constexpr std::array kMovements = {Movement{MovementKind::kSitToStand, "sit-to-stand", "rise", FoundRises,
                                            StsEventKind::kOnset, StsEventKind::kStanding, false},
                                   Movement{MovementKind::kWalking, "walking", "stride", FoundStrides,
                                            StsEventKind::kHeelStrike, StsEventKind::kHeelStrike, true},
                                   Movement{MovementKind::kSquat, "squat", "squat", FoundSquats, StsEventKind::kDescent,
                                            StsEventKind::kStanding, false}};

template <typename Kind>
Option& AddMovement(Kind& kind, OptionList& options) {
  OptionList::Choices<MovementKind> choices = {{NameOf(MovementKind::kAuto), MovementKind::kAuto}};
  for (const Movement& movement : kMovements) choices.emplace_back(movement.name, movement.kind);
  return options.AddChoice("movement", kind, choices, "Movement whose repetitions are found; auto: by the motion");
}

}  // namespace

void DescribeMovement(std::optional<MovementKind>& kind, OptionList& options) {
  AddMovement(kind, options).Otherwise("as the trials say it");
}

void Describe(MovementOptions& o, OptionList& options) {
  AddMovement(o.kind, options);
  options
      .AddChoice("walking", o.walking.ground,
                 OptionList::Choices<Ground>{{"overground", Ground::kOverground}, {"treadmill", Ground::kTreadmill}},
                 "Where the person walks")
      .Otherwise("found from the motion");
  options.Add("belt-speed", o.walking.belt_speed_mm_s, "Speed of the treadmill's belt")
      .Unit("mm/s")
      .Positive()
      .Otherwise("that of the foot in stance");
}

std::span<const Movement> Movements() {
  return kMovements;
}

const Movement& MovementOf(MovementKind kind) {
  return *std::ranges::find(kMovements, kind, &Movement::kind);
}

const char* NameOf(MovementKind kind) {
  return kind == MovementKind::kAuto ? "auto" : MovementOf(kind).name;
}

void ChooseMovement(const MovementOptions& options, LegFitResult& leg) {
  leg.movement = {.kind = std::nullopt, .walk = {}, .walking = options.walking};
  std::vector<StsEvent> chosen;
  for (const Movement& movement : kMovements) {
    if (options.kind != MovementKind::kAuto && options.kind != movement.kind) continue;
    std::vector<StsEvent> found = movement.find(leg, options, leg.movement.walk);
    if (found.empty()) continue;
    if (!leg.movement.kind) {
      leg.movement.kind = movement.kind;
      chosen = std::move(found);
      continue;
    }
    // Somebody who sits down, stands up and walks is measured as the first of both.
    const Movement& first = MovementOf(*leg.movement.kind);
    if (movement.kind == MovementKind::kWalking)
      leg.warnings.push_back(fmt::format("{0} and {1} are both seen; {0} is measured, {1} with --movement {1}",
                                         first.name, movement.name));
  }
  const bool is_walking = leg.movement.kind == MovementKind::kWalking;
  if (is_walking)
    if (const std::optional<std::string> oblique = ObliqueWalk(leg)) leg.warnings.push_back("walking: " + *oblique);
  if (options.kind == MovementKind::kWalking && chosen.empty() && leg.movement.walk.left_out.empty())
    leg.warnings.emplace_back(
        "walking: nobody is seen to walk: no foot is carried from behind the hip to before it and put down; no cycle "
        "is measured");
  if (is_walking || chosen.empty())
    for (const std::string& sentence : leg.movement.walk.left_out) leg.warnings.push_back("walking: " + sentence);
  if (is_walking && options.walking.belt_speed_mm_s && leg.movement.walk.ground == Ground::kOverground)
    leg.warnings.emplace_back(
        "walking: overground, so that the belt's speed is left out: if it is on a treadmill, give --walking treadmill");
  constexpr double kMostBeside_s =
      0.04;  // markers err by less; heels that struck 14 cm before a plate by 56 ms and more
  for (const PlateEvent& of : leg.movement.walk.by_plate)
    if (std::abs(of.markers_later_s) > kMostBeside_s)
      leg.warnings.push_back(
          fmt::format("walking: {} at {:.3f} s is where a force plate has it, the markers show it {:.0f} ms {}: was "
                      "the foot beside the plate there? Give the event with --events, or leave --forces out",
                      ToString(of.event.kind), of.event.time_s, 1000 * std::abs(of.markers_later_s),
                      of.markers_later_s < 0 ? "earlier" : "later"));
  const bool was_asked = options.kind == MovementKind::kWalking && !leg.movement.walk.left_out.empty();
  if ((is_walking || was_asked) && leg.movement.walk.strides == 0)
    leg.warnings.emplace_back(
        "walking: no stride is seen from one heel strike to the next of the same leg: no cycle is measured");
  if (leg.movement.kind == MovementKind::kSquat)
    std::erase_if(leg.warnings, [](const std::string& warning) { return warning.starts_with("rises without a seat"); });
  leg.events = std::move(chosen);
  SetRepetitions(leg.events, leg.motion);
}

void SetRepetitions(const std::vector<StsEvent>& events, motion::LegMotion& motion) {
  for (motion::LegSample& sample : motion.samples) {
    sample.repetition.reset();
    sample.percent = motion::LegSample::kUnknown;
  }
  std::map<std::pair<StsEventKind, int>, double> time_s;
  for (const StsEvent& event : events) time_s[{event.kind, event.repetition}] = event.time_s;
  for (const Movement& movement : kMovements)
    for (const auto& [key, begin_s] : time_s) {
      const auto& [kind, repetition] = key;
      const auto end = time_s.find({movement.end, repetition + (movement.ends_in_next ? 1 : 0)});
      if (kind != movement.begin || end == time_s.end() || end->second < begin_s) continue;
      const double duration_s = end->second - begin_s;
      for (std::size_t i = 0; i < motion.samples.size(); ++i) {
        if (motion.time_s[i] < begin_s || motion.time_s[i] > end->second) continue;
        motion.samples[i].repetition = repetition;
        motion.samples[i].percent = duration_s > 0 ? 100 * (motion.time_s[i] - begin_s) / duration_s : 100;
      }
    }
}

void DescribeEvents(std::optional<std::filesystem::path>& file, OptionList& options) {
  options.Add(
      "events", file,
      "repetition,event,time_s (or frame) rows that overrule the events found (of walking: all of them); empty: no "
      "such event");
}

void CorrectEvents(const std::vector<motion::EventCorrection>& corrections, LegFitResult& fit) {
  fit.events = motion::ApplyEventCorrections(corrections, fit.motion.frame, fit.motion.time_s, fit.events);
  CountStrides(fit.events, fit.movement.walk);
  if (std::ranges::any_of(fit.events,
                          [](const auto& event) { return event.kind >= motion::StsEventKind::kHeelStrike; }))
    fit.movement.kind = MovementKind::kWalking;
  SetRepetitions(fit.events, fit.motion);
}

motion::LegSample NeutralPose(const LegFitResult& leg, double from_s, double to_s) {
  constexpr double kMostSway_deg = 3, kMostBend_deg = 30;
  from_s = std::max(from_s, leg.motion.time_s.front());
  to_s = std::min(to_s, leg.motion.time_s.back());
  motion::LegSample pose;
  for (const motion::Angle& angle : motion::Angles()) {
    std::vector<double> deg, sigma_deg;
    for (std::size_t i = 0; i < leg.motion.samples.size(); ++i) {
      const motion::LegSample& sample = leg.motion.samples[i];
      if (leg.motion.time_s[i] < from_s || leg.motion.time_s[i] > to_s || !std::isfinite(sample.*angle.deg)) continue;
      deg.push_back(sample.*angle.deg);
      sigma_deg.push_back(sample.*angle.sigma_deg);
    }
    const bool is_of_leg = angle.deg == &motion::LegSample::knee_deg || angle.deg == &motion::LegSample::shank_deg;
    if (is_of_leg && deg.size() < kLeastFrames)
      throw Fail("no quiet standing from {:g} to {:g} s: {} frames show the leg there, at least {} are needed", from_s,
                 to_s, deg.size(), kLeastFrames);
    if (deg.size() < kLeastFrames) continue;
    const double sway_deg = StandardDeviation(deg);
    if (is_of_leg && sway_deg > kMostSway_deg)
      throw Fail("no quiet standing from {:g} to {:g} s: the {}'s angle sways by {:.1f} deg (SD) there, at most {:g}",
                 from_s, to_s, angle.name, sway_deg, kMostSway_deg);
    pose.*angle.deg = Mean(deg);
    pose.*angle.sigma_deg = std::hypot(sway_deg, RootMeanSquare(sigma_deg));
  }
  if (pose.knee_deg > kMostBend_deg)
    throw Fail("no quiet standing from {:g} to {:g} s: the knee is bent by {:.0f} deg there", from_s, to_s,
               pose.knee_deg);
  return pose;
}

}  // namespace lake::gait
