// Curves over a movement.
#pragma once

#include <vector>

#include "lake/report/report.h"

namespace lake::figure {

// 0, 1, … count - 1.
inline std::vector<double> Percents(std::size_t count) {
  std::vector<double> percents;
  for (std::size_t percent = 0; percent < count; ++percent) percents.push_back(static_cast<double>(percent));
  return percents;
}

// One value per percent.
inline report::Series OverPercent(std::string name, std::vector<double> values, const char* colour,
                                  report::Mark mark = report::Mark::kLine) {
  return {
      .name = std::move(name), .x = Percents(values.size()), .y = std::move(values), .colour = colour, .mark = mark};
}

}  // namespace lake::figure
