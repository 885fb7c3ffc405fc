
#include <fmt/format.h>

#include <cmath>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/parts/mechanism.h"

namespace lake::parts {
namespace {

constexpr Material kMaterials[] = {
    {"6061-T6", 2700, 240, "EN 1999-1-1, table 3.2 and 3.2.5: EN AW-6061 T6, 0.2 % proof strength"},
    {"S235", kSteelDensity_kg_m3, 235, "EN 10025-2: S235JR up to 16 mm"},
    {"PLA", 1264, 26, "Stratasys, data sheet of PLA: ASTM D638 yield of the weaker direction, ASTM D792"},
};

using Eigen::Vector2d;

// "4mm,PLA"
void ReadPlate(const std::string& text, const std::string& said, PartOptions& o) {
  const std::size_t comma = text.find(',');
  std::string_view thickness = Trim(std::string_view(text).substr(0, comma));
  if (thickness.ends_with("mm")) thickness = Trim(thickness.substr(0, thickness.size() - 2));
  const auto number = ParseNumber(thickness);
  if (!number || comma == std::string::npos)
    throw UsageError("{} '{}': a thickness and a material, such as 4mm,PLA", said, text);
  o.thickness_mm = *number;
  o.material = MaterialOf(Trim(std::string_view(text).substr(comma + 1))).name;
}

struct PlateMaker {
  const PartOptions& options;

  Plate Make(Body body, const char* label, std::vector<Vector2d> corners) const {
    Plate plate;
    plate.name = NameOf(body);
    plate.label = label;
    plate.corners = std::move(corners);
    plate.radius_mm = options.bar_width_mm / 2;
    plate.thickness_mm = options.thickness_mm;
    plate.density_kg_m3 = MaterialOf(options.material).density_kg_m3;
    return plate;
  }

  void AddPinHole(Plate& plate, const Vector2d& at) const {
    plate.holes.push_back({at, options.pin_diameter_mm + options.bore_clearance_mm});
  }

  // Two, from a plate's width beyond a pin on.
  void AddCuffHoles(Plate& plate, const Vector2d& pin, const Vector2d& direction) const {
    for (const double along : {0.0, options.cuff_hole_spacing_mm})
      plate.holes.push_back({pin + (options.bar_width_mm + along) * direction, options.cuff_hole_diameter_mm});
  }

  // From the pin to the middle of the last cuff hole.
  double CuffReach() const { return options.bar_width_mm + options.cuff_hole_spacing_mm; }

  Plate Bar(Body body, const char* label, double length) const {
    Plate plate = Make(body, label, {{0, 0}, {length, 0}});
    for (const Vector2d& corner : plate.corners) AddPinHole(plate, corner);
    return plate;
  }

  Plate Shank(double l4) const {
    Plate plate = Make(Body::kShank, "KS", {{0, 0}, {l4 + CuffReach(), 0}});
    AddPinHole(plate, {0, 0});
    AddPinHole(plate, {l4, 0});
    AddCuffHoles(plate, {l4, 0}, {1, 0});
    return plate;
  }

  Plate Thigh(const linkage::Links& l) const {
    const Vector2d thigh_pin(0, l.l3), mount(l.l5, l.l3 + l.l6);
    Plate plate = Make(Body::kThigh, "KPM", {{0, 0}, mount, thigh_pin});
    for (const Vector2d& pin : {Vector2d(0, 0), thigh_pin, mount}) AddPinHole(plate, pin);
    if (l.L7() >= CuffReach() + options.bar_width_mm) AddCuffHoles(plate, thigh_pin, (mount - thigh_pin).normalized());
    return plate;
  }
};

}  // namespace

void PartOptions::Check() const {
  if (!(bar_width_mm > 0 && bar_width_mm < 1000)) throw Fail("a plate width of {} mm cannot be cut", bar_width_mm);
  if (!(thickness_mm > 0 && thickness_mm < 100)) throw Fail("a plate thickness of {} mm cannot be cut", thickness_mm);
  const auto hole_fits = [&](const char* what, double diameter) {
    if (!(diameter > 0 && diameter < bar_width_mm))
      throw Fail("{} of {} mm does not fit a plate of {} mm", what, diameter, bar_width_mm);
  };
  hole_fits("a pin", pin_diameter_mm);
  hole_fits("a bore", pin_diameter_mm + bore_clearance_mm);
  hole_fits("a cuff's hole", cuff_hole_diameter_mm);
  if (!(actuator_eye_mm > 0 && actuator_eye_mm <= actuator_diameter_mm))
    throw Fail("an actuator's eye of {} mm must be within its diameter, {} mm", actuator_eye_mm, actuator_diameter_mm);
  if (!(rod_diameter_mm > 0 && rod_diameter_mm < actuator_diameter_mm))
    throw Fail("a rod of {} mm does not fit an actuator of {} mm", rod_diameter_mm, actuator_diameter_mm);
  if (!(cuff_hole_spacing_mm > cuff_hole_diameter_mm && cuff_hole_spacing_mm < 1000))
    throw Fail("a cuff's holes of {} mm cannot be {} mm apart", cuff_hole_diameter_mm, cuff_hole_spacing_mm);
}

void Describe(PartOptions& o, OptionList& options) {
  options.Add("bar-width", o.bar_width_mm, "Width of the link plates").Unit("mm");
  options
      .AddCustom(
          "plate", "Thickness and material of the plates: 6061-T6, S235 or PLA",
          [&o](const OptionTexts& texts, const std::string& said) {
            CheckTextCount(texts, 1, said);
            ReadPlate(texts.front(), said, o);
          },
          [&o] { return fmt::format("{}mm,{}", o.thickness_mm, o.material); })
      .Value("MM,MATERIAL");
  options.Add("pin-diameter", o.pin_diameter_mm, "Diameter of the pins").Unit("mm");
  options.Add("bore-clearance", o.bore_clearance_mm, "How much wider than its pin a hole is").Unit("mm").NotNegative();
  options.Add("layer-gap", o.gap_mm, "Between neighbouring plates: a washer, or a pin's retaining ring")
      .Unit("mm")
      .Between(0, 100);
  options.Add("clearance", o.clearance_mm, "Between parts that pass each other in one layer")
      .Unit("mm")
      .Between(0, 100);
  options.Add("cuff-hole-diameter", o.cuff_hole_diameter_mm, "Holes for the cuffs, two on thigh plate and shank link")
      .Unit("mm");
  options.Add("cuff-hole-spacing", o.cuff_hole_spacing_mm, "Between the two holes of a cuff").Unit("mm");
  options.Add("actuator-diameter", o.actuator_diameter_mm, "Diameter of the actuator").Unit("mm").Between(1, 1000);
  options.Add("actuator-eye", o.actuator_eye_mm, "Width of the actuator's eyes along the pins").Unit("mm");
  options.Add("actuator-mass", o.actuator_mass_kg, "Mass of the actuator without its rod").Unit("kg").Positive();
  options.Add("rod-diameter", o.rod_diameter_mm, "Diameter of the actuator's rod").Unit("mm");
}

std::string_view NameOf(Body body) {
  constexpr std::string_view kNames[] = {"thigh plate", "shank link", "coupler", "slewing bar", "actuator"};
  return kNames[static_cast<std::size_t>(body)];
}

std::string_view LetterOf(Joint joint) {
  constexpr std::string_view kLetters[] = {"K", "P", "R", "S", "M"};
  return kLetters[static_cast<std::size_t>(joint)];
}

Vector2d Placement::operator*(const Vector2d& p) const {
  const double c = std::cos(turn_rad), s = std::sin(turn_rad);
  return {at_mm.x() + c * p.x() - s * p.y(), at_mm.y() + s * p.x() + c * p.y()};
}

Vector2d PlaceOf(Joint joint, const linkage::Pose& pose) {
  switch (joint) {
    case Joint::kKnee:
      return pose.knee;
    case Joint::kThighPin:
      return pose.thigh_pin;
    case Joint::kTip:
      return pose.tip;
    case Joint::kShankPin:
      return pose.shank_pin;
    case Joint::kMount:
      break;
  }
  return pose.mount;
}

Placement PlacementOf(Body body, const linkage::Pose& pose) {
  const auto between = [&](const Vector2d& from, const Vector2d& to) {
    return Placement{from, std::atan2(to.y() - from.y(), to.x() - from.x())};
  };
  switch (body) {
    case Body::kThigh:
      return {};
    case Body::kShank:
      return between(pose.knee, pose.shank_pin);
    case Body::kCoupler:
      return between(pose.tip, pose.shank_pin);
    case Body::kBar:
      return between(pose.thigh_pin, pose.tip);
    case Body::kActuator:
      break;
  }
  return between(pose.mount, pose.tip);
}

std::array<Plate, kPlates> PlatesOf(const linkage::Links& links, const PartOptions& options) {
  linkage::CheckLinks(links, "links");
  options.Check();
  const PlateMaker maker{options};
  return {maker.Thigh(links), maker.Shank(links.l4), maker.Bar(Body::kCoupler, "RS", links.l1),
          maker.Bar(Body::kBar, "PR", links.l2)};
}

const Material& MaterialOf(std::string_view name) {
  std::string known;
  for (const Material& material : kMaterials) {
    if (material.name == name) return material;
    known += (known.empty() ? "" : ", ") + std::string(material.name);
  }
  throw UsageError("no material '{}': there are {}", name, known);
}

}  // namespace lake::parts
