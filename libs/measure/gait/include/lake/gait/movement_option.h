// --movement of programs that have others measure trials: it takes the place of what these are told.
#pragma once

#include <optional>

#include "lake/gait/movement.h"

namespace lake::gait {

// nullopt: as the trials say it.
void DescribeMovement(std::optional<MovementKind>& kind, OptionList& options);

const char* NameOf(MovementKind kind);  // as --movement has it

}  // namespace lake::gait
