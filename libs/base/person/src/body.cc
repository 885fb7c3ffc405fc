#include "lake/person/body.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/plausible.h"

namespace lake::person {
namespace {

// Ratios of one segment: mass / body mass, centre of mass from the proximal end / length, density.
struct SegmentRatios {
  double mass, centre, density_kg_m3;
};
constexpr SegmentRatios kThighMass{0.100, 0.433, 1050}, kShankMass{0.0465, 0.433, 1090}, kTrunkMass{0.497, 0.50, 1030};
constexpr double kShoulderBreadth = 0.259, kNeckLength = 0.052, kHeadHeight = 0.130;

double VolumeOf(const SegmentRatios& ratios, double mass_kg) {
  constexpr double kCubicMillimetresPerCubicMetre = 1e9;
  return ratios.mass * mass_kg / ratios.density_kg_m3 * kCubicMillimetresPerCubicMetre;
}

// Distal over proximal radius k of the frustum with centre of mass c: c = (1 + 2k + 3k^2) / (4 (1 + k + k^2)).
double TaperOf(double centre) {
  const double a = 3 - 4 * centre, b = 2 - 4 * centre, c = 1 - 4 * centre;
  return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
}

LimbSegment SegmentOf(const SegmentRatios& ratios, double length_mm, double mass_kg) {
  const double k = TaperOf(ratios.centre);
  const double radius = std::sqrt(3 * VolumeOf(ratios, mass_kg) / (std::numbers::pi * length_mm * (1 + k + k * k)));
  return {length_mm, radius, k * radius};
}

}  // namespace

double LimbSegment::RadiusAt(double from_distal_mm) const {
  const double fraction = std::clamp(from_distal_mm / length_mm, 0.0, 1.0);
  return distal_radius_mm + fraction * (proximal_radius_mm - distal_radius_mm);
}

Body BodyOf(double height_mm, double mass_kg) {
  for (const auto& [value, range] : {std::pair{height_mm, kPlausibleStature}, {mass_kg, kPlausibleMass}})
    if (!range.Holds(value))
      throw Fail("a body of {} {} is outside {}..{} {}", value, range.unit, range.low, range.high, range.unit);
  Body body{.height_mm = height_mm,
            .mass_kg = mass_kg,
            .thigh = SegmentOf(kThighMass, kThigh * height_mm, mass_kg),
            .shank = SegmentOf(kShankMass, kShank * height_mm, mass_kg),
            .foot_length_mm = kFoot * height_mm,
            .ankle_height_mm = kAnkleHeight * height_mm,
            .trunk_length_mm = kTrunk * height_mm};
  // An ellipse of area pi / 4 x breadth x depth over the trunk's length.
  body.trunk_depth_mm =
      VolumeOf(kTrunkMass, mass_kg) / (std::numbers::pi / 4 * kShoulderBreadth * height_mm * body.trunk_length_mm);
  body.head_height_mm = kHeadHeight * height_mm;
  body.neck_length_mm = kNeckLength * height_mm;
  return body;
}

double HeightOf_mm(const LegLengths& leg) {
  return (leg.thigh_mm + leg.shank_mm) / (kThigh + kShank);
}

double MassAtHeight_kg(double height_mm, double other_height_mm, double other_mass_kg) {
  const double ratio = height_mm / other_height_mm;
  return other_mass_kg * ratio * ratio;
}

Body WithLeg(Body body, const LegLengths& leg) {
  for (const double length_mm : {leg.thigh_mm, leg.shank_mm})
    if (!kPlausibleSegment.Holds(length_mm))
      throw Fail("a thigh of {} mm and a shank of {} mm: both must be within {}..{} mm", leg.thigh_mm, leg.shank_mm,
                 kPlausibleSegment.low, kPlausibleSegment.high);
  body.thigh = SegmentOf(kThighMass, leg.thigh_mm, body.mass_kg);
  body.shank = SegmentOf(kShankMass, leg.shank_mm, body.mass_kg);
  return body;
}

Body BodyOf(const BodySize& size) {
  constexpr double kAverageHeight_mm = 1800, kAverageMass_kg = 80;
  const double height_mm = size.height_mm.value_or(size.leg ? HeightOf_mm(*size.leg) : kAverageHeight_mm);
  const double mass_kg = size.mass_kg.value_or(MassAtHeight_kg(height_mm, kAverageHeight_mm, kAverageMass_kg));
  const Body body = BodyOf(height_mm, mass_kg);
  return size.leg ? WithLeg(body, *size.leg) : body;
}

void Describe(BodySize& o, OptionList& options) {
  const auto add_length = [&](const char* name, const char* help, double LegLengths::*length) {
    const auto set = [&o, length](const OptionTexts& texts, const std::string& said) {
      if (!o.leg) o.leg.emplace();
      OptionField<double>::Set(texts, said, (*o.leg).*length);
    };
    options.AddCustom(name, help, set, [&o, length] { return o.leg ? FormatNumber((*o.leg).*length) : ""; })
        .Unit("mm")
        .Positive()
        .Otherwise("by body height");
  };
  add_length("thigh", "The person's thigh, hip to knee", &LegLengths::thigh_mm);
  add_length("shank", "The person's shank, knee to ankle", &LegLengths::shank_mm);
  options.Add("height", o.height_mm, "Body height").Unit("mm").Positive().Otherwise("1800, or by thigh and shank");
  options.Add("mass", o.mass_kg, "Body mass").Unit("kg").Positive().Otherwise("80 at 1800 mm, else of the same BMI");
  options.Check([&o](const OptionList& list) {
    if (o.leg && (o.leg->thigh_mm == 0 || o.leg->shank_mm == 0))
      throw UsageError("--thigh and --shank (thigh_mm, shank_mm) are one leg: give both or neither");
    if (o.leg && list.IsGiven("height") && !list.IsGiven("thigh") && !list.IsGiven("shank"))
      throw UsageError(
          "--height {} mm: the file has the person's own thigh and shank ({} and {} mm), which a height does not "
          "change; give --thigh and --shank too, or take thigh_mm and shank_mm out of the file",
          *o.height_mm, o.leg->thigh_mm, o.leg->shank_mm);
  });
}

}  // namespace lake::person
