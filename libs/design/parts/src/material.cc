#include "lake/parts/material.h"

#include <fmt/format.h>

#include <string>

#include "lake/core/error.h"

namespace lake::parts {
namespace {

constexpr Material kMaterials[] = {
    {"6061-T6", 2700, 240, "EN 1999-1-1, table 3.2 and 3.2.5: EN AW-6061 T6, 0.2 % proof strength"},
    {"S235", kSteelDensity_kg_m3, 235, "EN 10025-2: S235JR up to 16 mm"},
    {"PLA", 1264, 26, "Stratasys, data sheet of PLA: ASTM D638 yield of the weaker direction, ASTM D792"},
};

}  // namespace

const Material& MaterialOf(std::string_view name) {
  std::string known;
  for (const Material& material : kMaterials) {
    if (material.name == name) return material;
    known += (known.empty() ? "" : ", ") + std::string(material.name);
  }
  throw UsageError("no material '{}': there are {}", name, known);
}

}  // namespace lake::parts
