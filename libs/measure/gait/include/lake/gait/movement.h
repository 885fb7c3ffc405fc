// The movements that are known: how their repetitions are found, and what is 0 and 100 % of them.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lake/core/options.h"
#include "lake/gait/walking.h"

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

}  // namespace lake::gait
