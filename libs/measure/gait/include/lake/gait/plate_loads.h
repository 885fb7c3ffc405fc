// When a foot is on a force plate, by the force.
#pragma once

#include <vector>

namespace lake::gait {

// A foot's load on a plate: from where the vertical force rises above 20 N over what the empty plate reads to where it
// falls below, between samples (Zeni et al. 2008, doi:10.1016/j.gaitpost.2007.07.007); NaN: it bears already when the
// recording begins, or still when it ends. Loads of less than 0.1 s, and gaps of less than 0.05 s, are the plate's
// noise.
struct PlateLoad {
  double begin_s, end_s;
  double begin_sd_s, end_sd_s;  // by the empty plate's noise over the force's slope, and half a sample
};
// Of a plate's vertical force.
std::vector<PlateLoad> LoadsOf(const std::vector<double>& force_n, const std::vector<double>& time_s);

}  // namespace lake::gait
