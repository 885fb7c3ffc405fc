// The sizes of the leg fit that are not options, each of which stands for the same thing wherever it is used.
// Not part of the interface.
#pragma once

#include <cstddef>

namespace lake::gait {

inline constexpr double kMovement_s = 0.2;  // a limb's roughness, and what skin does beside it, is alike for so long
inline constexpr double kForgiven = 0.5;    // of the scatter of a mean of squares: taken for chance
inline constexpr double kOfSomethingElse = 0.1;  // of the detections that their neighbours speak against
inline constexpr double kTranslation = 1.5;      // noise deviations from a measurement to its estimate, at most
inline constexpr std::size_t kLeastFrames = 8;   // for a curve

}  // namespace lake::gait
