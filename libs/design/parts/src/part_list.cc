#include <fmt/format.h>

#include <numbers>

#include "lake/parts/mechanism.h"

namespace lake::parts {
namespace {

constexpr double kGramsPerKilogram = 1000;

// Of steel, a tube if it has a bore.
double TubeMass_g(double length_mm, double diameter_mm, double bore_mm) {
  constexpr double kGramsPerCubicMillimetre = kSteelDensity_kg_m3 * 1e-6;
  return std::numbers::pi / 4 * (diameter_mm * diameter_mm - bore_mm * bore_mm) * length_mm * kGramsPerCubicMillimetre;
}

PartRow PlateRow(const Plate& plate, const Span& span, const PartOptions& options) {
  PartRow row{fmt::format("{} {}", plate.name, plate.label), options.material};
  double longest = 0;
  for (const Eigen::Vector2d& a : plate.corners)
    for (const Eigen::Vector2d& b : plate.corners) longest = std::max(longest, (a - b).norm());
  row.length_mm = longest + 2 * plate.radius_mm;
  row.width_mm = 2 * plate.radius_mm;
  if (plate.corners.size() > 2) row.width_mm.reset();
  row.thickness_mm = plate.thickness_mm;
  row.bore_mm = plate.holes.front().diameter_mm;
  row.mass_g = kGramsPerKilogram * MassOf(plate).mass_kg;
  row.span = span;
  return row;
}

}  // namespace

std::vector<PartRow> PartList(const Mechanism& mechanism) {
  const PartOptions& options = mechanism.options;
  std::vector<PartRow> rows;
  for (std::size_t i = 0; i < kPlates; ++i)
    rows.push_back(PlateRow(mechanism.plates[i], mechanism.stack.span[i], options));
  for (const Pin& pin : mechanism.stack.pins) {
    PartRow row{fmt::format("pin {}", LetterOf(pin.joint)), "steel"};
    row.length_mm = pin.span.Length();
    row.diameter_mm = options.pin_diameter_mm;
    row.mass_g = TubeMass_g(*row.length_mm, options.pin_diameter_mm, 0);
    row.span = pin.span;
    rows.push_back(row);
  }
  for (const Spacer& spacer : mechanism.stack.spacers) {
    PartRow row{fmt::format("spacer {}", LetterOf(spacer.joint)), "steel"};
    row.length_mm = spacer.span.Length();
    row.diameter_mm = spacer.outer_diameter_mm;
    row.bore_mm = spacer.inner_diameter_mm;
    row.mass_g = TubeMass_g(*row.length_mm, spacer.outer_diameter_mm, spacer.inner_diameter_mm);
    row.span = spacer.span;
    rows.push_back(row);
  }
  PartRow ring{"retaining ring", "steel"};
  ring.quantity = static_cast<int>(2 * kJoints);
  ring.bore_mm = options.pin_diameter_mm;
  rows.push_back(ring);
  PartRow screw{"cuff screw, countersunk", "steel"};
  screw.quantity = mechanism.HasThighCuffHoles() ? 4 : 2;
  screw.bore_mm = options.cuff_hole_diameter_mm;
  rows.push_back(screw);
  PartRow actuator{"linear actuator", ""};
  actuator.length_mm = mechanism.range.stroke.lower_mm;
  actuator.diameter_mm = options.actuator_diameter_mm;
  actuator.thickness_mm = options.actuator_eye_mm;
  actuator.bore_mm = options.pin_diameter_mm + options.bore_clearance_mm;
  actuator.span = mechanism.stack.span[static_cast<std::size_t>(Body::kActuator)];
  rows.push_back(actuator);
  return rows;
}

}  // namespace lake::parts
