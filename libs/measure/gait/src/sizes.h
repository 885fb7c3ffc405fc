// The sizes of the leg fit that are not options. Not part of the interface.
#pragma once

#include <cstddef>

namespace lake::gait {

inline constexpr double kMovement_s = 0.2;       // a marker's speed is the movement over this time
inline constexpr double kMemory_s = 0.1;         // a movement that is not seen goes on as it was for about this time
inline constexpr double kOfSomethingElse = 0.1;  // of the detections that are not trusted
inline constexpr std::size_t kLeastFrames = 8;   // for a curve
// For so long the error of a rebuilt knee stays alike: 0.15 to 0.22 s in rises and walks.
inline constexpr double kRebuiltMemory_s = 0.2;

}  // namespace lake::gait
