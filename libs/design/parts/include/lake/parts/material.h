// Materials of plates.
#pragma once

#include <string_view>

namespace lake::parts {

struct Material {
  std::string_view name;
  double density_kg_m3;
  double yield_mpa;  // in tension, least direction
  std::string_view source;
};

// Throws UsageError that lists the known ones.
const Material& MaterialOf(std::string_view name);

// Of pins and the actuator's rod: structural steel, EN 10025-2 and EN 1993-1-1, 3.2.6.
inline constexpr double kSteelDensity_kg_m3 = 7850;
inline constexpr double kSteelModulus_mpa = 210'000;

}  // namespace lake::parts
