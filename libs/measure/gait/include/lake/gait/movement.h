// The movements that are known: how their repetitions are found, and what is 0 and 100 % of them.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lake/core/options.h"
#include "lake/gait/walking.h"
#include "lake/motion/event_corrections.h"

namespace lake::gait {

enum class MovementKind { kAuto, kSitToStand, kSquat, kWalking };

struct MovementOptions {
  MovementKind kind = MovementKind::kAuto;  // found from the motion
  WalkingOptions walking;
};

// --movement, --walking and --belt-speed.
void Describe(MovementOptions& o, OptionList& options);
// --movement of programs that have others measure trials, in place of what these say; nullopt: as they say it.
void DescribeMovement(std::optional<MovementKind>& kind, OptionList& options);

const char* NameOf(MovementKind kind);  // as --movement has it

// What was found in a recording.
struct FoundMovement {
  std::optional<MovementKind> kind;  // nullopt: none that is known
  Walk walk;                         // of walking
  WalkingOptions walking;            // with which it was found
};

struct Movement {
  MovementKind kind;
  const char* name;        // as --movement has it
  const char* repetition;  // what one is called
  std::vector<motion::StsEvent> (*find)(const LegFitResult& leg, const MovementOptions& options, Walk& walk);
  motion::StsEventKind begin, end;  // 0 and 100 %
  bool ends_in_next;                // the end is the next repetition's
};

std::span<const Movement> Movements();
const Movement& MovementOf(MovementKind kind);

// Puts the events of the movement that the options name, else of the first of the table that the motion shows, in the
// place of the fit's, and with them repetition and percent; warns of what it leaves out, and where another movement is
// seen too. Without any, a warning says so and the events are empty.
void ChooseMovement(const MovementOptions& options, LegFitResult& leg);

// The option --events: a file of rows where a person knows better than what was found in the motion.
void DescribeEvents(std::optional<std::filesystem::path>& file, OptionList& options);

// Puts the rows in the places of what was found; repetition and percent of each frame follow. Throws Error as
// motion::ApplyEventCorrections does.
void CorrectEvents(const std::vector<motion::EventCorrection>& corrections, LegFitResult& fit);

// Quiet standing: the means of all angles over the frames from one time to another; their standard deviations are the
// person's sway there, with the markers' noise of a frame. Throws Error: fewer than eight frames show the knee there,
// its angle or the shank's sways by more than 3° (SD), or the knee is bent by more than 30°: nobody stands quietly
// there.
motion::LegSample NeutralPose(const LegFitResult& leg, double from_s, double to_s);

}  // namespace lake::gait
