#include "lake/gait/movement.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "lake/gait/leg_fit.h"
#include "lake/gait/squats.h"
#include "oblique_walk.h"

namespace lake::gait {
namespace {

using motion::StsEvent;
using motion::StsEventKind;

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

}  // namespace lake::gait
