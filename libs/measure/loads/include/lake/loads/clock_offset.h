// Whether the forces' clock is that of the markers: while the feet alone bear the body, the ground's vertical force
// follows the body's acceleration, which the markers show.
#pragma once

#include <optional>
#include <span>

#include "lake/loads/trunk_fit.h"

namespace lake::loads {

struct ClockOffset {
  double add_s = 0;  // to the forces' times, so that they are the markers'
  double sd_s = 0;   // one standard deviation: of the fit, and of what the body's model takes for granted
};

// The offset, at most a second either way, at which the forces follow best what the motion needs (sync::FindLag):
// vertical forces at the frames' times, NaN where not known. Their ratio may be any: nobody knows how much of the body
// this foot bears. nullopt where the forces do not follow the motion, so that there is no offset.
std::optional<ClockOffset> FindClockOffset(std::span<const double> time_s, std::span<const double> needed_n,
                                           std::span<const double> measured_n, std::span<const Window> windows);

}  // namespace lake::loads
