#include "part_tables.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/csv.h"

namespace lake::commands {
namespace {

// A thousandth of a millimetre or gram: finer than anybody makes or weighs.
double ForWorkshop(double value) {
  constexpr double kSteps = 1000;
  return std::round(kSteps * value) / kSteps;
}

}  // namespace

void WritePartList(const std::filesystem::path& path, const parts::Mechanism& mechanism) {
  CsvWriter table({"part", "quantity", "material", "length_mm", "width_mm", "thickness_mm", "diameter_mm", "bore_mm",
                   "mass_g", "from_mm", "to_mm"});
  for (const parts::PartRow& row : parts::PartList(mechanism)) {
    table.Add(row.part).Add(row.quantity).Add(row.material);
    for (const auto& number : {row.length_mm, row.width_mm, row.thickness_mm, row.diameter_mm, row.bore_mm, row.mass_g})
      table.Add(number ? std::optional(ForWorkshop(*number)) : std::nullopt);
    if (row.span)
      table.Add(ForWorkshop(row.span->from_mm)).Add(ForWorkshop(row.span->to_mm));
    else
      table.AddEmpty().AddEmpty();
    table.EndRow();
  }
  table.Write(path);
}

std::vector<std::vector<std::string>> LayersOf(const parts::Stack& stack) {
  std::vector<std::vector<std::string>> layers(1 + static_cast<std::size_t>(std::ranges::max(stack.layer)));
  for (std::size_t i = 0; i < parts::kBodies; ++i)
    layers[static_cast<std::size_t>(stack.layer[i])].emplace_back(parts::NameOf(static_cast<parts::Body>(i)));
  return layers;
}

double MassOf_g(const parts::Mechanism& mechanism) {
  double mass_g = 0;
  for (const parts::PartRow& row : parts::PartList(mechanism)) mass_g += row.quantity * row.mass_g.value_or(0);
  return mass_g;
}

Json PartsJson(const parts::Mechanism& mechanism) {
  return {
      {"layers", LayersOf(mechanism.stack)}, {"conflicts", mechanism.stack.conflicts}, {"mass_g", MassOf_g(mechanism)}};
}

void WarnOfStack(const parts::Mechanism& mechanism, Run& run) {
  if (!mechanism.stack.conflicts.empty())
    run.Warn(
        "no order of the plates keeps all parts apart: at best {}; narrower plates, thinner pins or a shorter range "
        "would help",
        fmt::join(mechanism.stack.conflicts, ", "));
  if (!mechanism.HasThighCuffHoles())
    run.Warn("P and M are too near to each other for a thigh cuff's holes: the thigh plate has none");
}

}  // namespace lake::commands
