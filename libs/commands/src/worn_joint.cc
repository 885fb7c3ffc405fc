#include "worn_joint.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "lake/compare/misalignment.h"

namespace lake::commands {
namespace {

using Eigen::Vector2d;

constexpr double kReach_mm = 40;  // per axis, as far as lake-optimize places a joint
constexpr double kStep_mm = 2;    // finer than a mount is fixed

// What was worn was possible, whatever overlaps seen from the side: nothing may reach further than that.
bool IsAllowed(const linkage::WearCheck& check, const linkage::WearCheck& as_worn) {
  constexpr double kRounding_mm = 1e-6;
  const auto is_no_worse = [](double clearance_mm, double worn_mm) {
    return clearance_mm >= std::min(0.0, worn_mm) - kRounding_mm;
  };
  return is_no_worse(check.mount_below_hip_mm, as_worn.mount_below_hip_mm) &&
         is_no_worse(check.seat_clearance_mm, as_worn.seat_clearance_mm) &&
         is_no_worse(check.thigh_clearance_mm, as_worn.thigh_clearance_mm) &&
         is_no_worse(check.shank_clearance_mm, as_worn.shank_clearance_mm);
}

// Within reach of the knee, the nearest first.
std::vector<Vector2d> PlacesAboutKnee() {
  std::vector<Vector2d> places;
  constexpr int kSteps = static_cast<int>(kReach_mm / kStep_mm);
  places.reserve((2 * kSteps + 1) * (2 * kSteps + 1));
  for (int i = -kSteps; i <= kSteps; ++i)
    for (int j = -kSteps; j <= kSteps; ++j) places.emplace_back(kStep_mm * i, kStep_mm * j);
  std::ranges::stable_sort(places, {}, [](const Vector2d& place) { return place.squaredNorm(); });
  return places;
}

// "the actuator overlaps the thigh by 68 mm and the shank by 43 mm, and the linkage reaches 53 mm into the seat"; empty
// where nothing collides.
std::string Collisions(const linkage::WearCheck& check) {
  std::vector<std::string> overlaps, collisions;
  const auto add = [](const std::string& text, double clearance_mm, std::vector<std::string>& to) {
    if (clearance_mm < 0) to.push_back(fmt::format(fmt::runtime(text), -clearance_mm));
  };
  add("the thigh by {:.0f} mm", check.thigh_clearance_mm, overlaps);
  add("the shank by {:.0f} mm", check.shank_clearance_mm, overlaps);
  if (!overlaps.empty()) collisions.push_back(fmt::format("the actuator overlaps {}", fmt::join(overlaps, " and ")));
  add("the linkage reaches {:.0f} mm into the seat", check.seat_clearance_mm, collisions);
  add("the mount reaches {:.0f} mm past the hip", check.mount_below_hip_mm, collisions);
  return fmt::format("{}", fmt::join(collisions, ", and "));
}

Json ClearancesJson(const linkage::WearCheck& check) {
  return {{"mount_below_hip_mm", check.mount_below_hip_mm},
          {"seat_clearance_mm", check.seat_clearance_mm},
          {"actuator_to_thigh_mm", check.thigh_clearance_mm},
          {"actuator_to_shank_mm", check.shank_clearance_mm},
          {"seat_edge_needed_mm", check.seat_edge_needed_mm}};
}

}  // namespace

WornJoint CheckWornJoint(const linkage::Design& worn, const Vector2d& offset_mm, const linkage::Body& body,
                         linkage::WearOptions wear) {
  const linkage::UsedRange range = linkage::FindUsedRange(worn.links, worn.d_min_mm, worn.d_max_mm);
  const auto at = [&](const Vector2d& place) {
    wear.placement_mm = {place.x(), place.y()};
    return linkage::CheckWear(worn.links, range, body, wear);
  };
  WornJoint joint{.as_worn = at(offset_mm), .moved = at(Vector2d::Zero()), .nearest_mm = {}};
  const std::vector<Vector2d> places = PlacesAboutKnee();
  const auto allowed =
      std::ranges::find_if(places, [&](const Vector2d& place) { return IsAllowed(at(place), joint.as_worn); });
  if (allowed != places.end()) joint.nearest_mm = *allowed;
  return joint;
}

std::string WornJointText(const WornJoint& joint, double unmoved_mm) {
  if (joint.nearest_mm && joint.nearest_mm->isZero())
    return "Seat and limbs allow it: nothing reaches further into them than as worn.";
  const std::string before = Collisions(joint.as_worn);
  std::string text = fmt::format("Seat or limbs are in the way of that: seen from the side, {}; as worn, {}.",
                                 Collisions(joint.moved), before.empty() ? "nothing overlaps" : before);
  if (!joint.moved.ClearsSeat())
    text += fmt::format(" A seat whose edge is at least {:.0f} mm behind the knee is clear of it.",
                        std::ceil(joint.moved.seat_edge_needed_mm));
  if (joint.nearest_mm)
    return text + fmt::format(
                      " The nearest place at which nothing reaches further than as worn is {}; it leaves {:.0f} mm RMS "
                      "between joint and knee.",
                      compare::DescribeJoint(*joint.nearest_mm), std::hypot(joint.nearest_mm->norm(), unmoved_mm));
  return text +
         fmt::format(" At every place within {:.0f} mm of the knee something reaches further than as worn.", kReach_mm);
}

Json WornJointJson(const WornJoint& joint) {
  Json json = {
      {"as_worn", ClearancesJson(joint.as_worn)}, {"moved", ClearancesJson(joint.moved)}, {"nearest_mm", nullptr}};
  if (const auto& nearest = joint.nearest_mm) json["nearest_mm"] = {nearest->x(), nearest->y()};
  return json;
}

}  // namespace lake::commands
