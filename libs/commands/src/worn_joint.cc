#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "comparison_tables.h"
#include "lake/compare/misalignment.h"

namespace lake::commands {
namespace {

using Eigen::Vector2d;

constexpr double kReach_mm = 40;  // per axis, as far as lake-optimize places a joint
constexpr double kStep_mm = 2;    // finer than a mount is fixed

// What was worn was possible, whatever overlaps seen from the side: nothing may reach further than that.
bool IsNoWorse(double clearance_mm, double worn_mm) {
  constexpr double kRounding_mm = 1e-6;
  return clearance_mm >= std::min(0.0, worn_mm) - kRounding_mm;
}

struct Clearance {
  double linkage::WearCheck::*mm;
  const char* overlap;                         // what a negative one means
  bool linkage::WearCheck::*is_met = nullptr;  // null: wherever the linkage is mounted

  bool Counts(const linkage::WearCheck& check) const { return !is_met || check.*is_met; }
};

constexpr std::array kClearances = {
    Clearance{&linkage::WearCheck::thigh_clearance_mm, "the actuator would overlap the thigh",
              &linkage::WearCheck::meets_limbs},
    Clearance{&linkage::WearCheck::shank_clearance_mm, "the actuator would overlap the shank",
              &linkage::WearCheck::meets_limbs},
    Clearance{&linkage::WearCheck::seat_clearance_mm, "the linkage would reach into the seat",
              &linkage::WearCheck::meets_seat},
    Clearance{&linkage::WearCheck::mount_below_hip_mm, "the mount would reach past the hip"}};

bool IsAllowed(const linkage::WearCheck& check, const linkage::WearCheck& as_worn) {
  return std::ranges::all_of(
      kClearances, [&](const Clearance& of) { return !of.Counts(check) || IsNoWorse(check.*of.mm, as_worn.*of.mm); });
}

// Nearer to the knee than `worn_mm`, the nearest first.
std::vector<Vector2d> PlacesAboutKnee(double worn_mm) {
  std::vector<Vector2d> places;
  constexpr int kSteps = static_cast<int>(kReach_mm / kStep_mm);
  constexpr std::size_t kPerAxis = 2 * kSteps + 1;
  places.reserve(kPerAxis * kPerAxis);
  for (int i = -kSteps; i <= kSteps; ++i)
    for (int j = -kSteps; j <= kSteps; ++j) places.emplace_back(kStep_mm * i, kStep_mm * j);
  std::erase_if(places, [&](const Vector2d& place) { return place.norm() > std::min(kReach_mm, worn_mm); });
  std::ranges::stable_sort(places, {}, [](const Vector2d& place) { return place.squaredNorm(); });
  return places;
}

// "the actuator would overlap the thigh by 68 mm (as worn: 60 mm)": what reaches further than as worn.
std::string Collisions(const linkage::WearCheck& check, const linkage::WearCheck& as_worn) {
  std::vector<std::string> collisions;
  for (const Clearance& of : kClearances)
    if (of.Counts(check) && !IsNoWorse(check.*of.mm, as_worn.*of.mm))
      collisions.push_back(fmt::format("{} by {:.0f} mm (as worn: {:.0f} mm)", of.overlap, -(check.*of.mm),
                                       std::max(0.0, -(as_worn.*of.mm))));
  return fmt::format("{}", fmt::join(collisions, ", and "));
}

Json ReachJson(const linkage::WearCheck& check) {
  return {{"mount_below_hip_mm", check.mount_below_hip_mm},
          {"seat_clearance_mm", check.seat_clearance_mm},
          {"actuator_to_thigh_mm", check.thigh_clearance_mm},
          {"actuator_to_shank_mm", check.shank_clearance_mm},
          {"seat_edge_needed_mm", check.seat_edge_needed_mm}};
}

}  // namespace

WornJoint CheckWornJoint(const linkage::Design& worn, const Vector2d& offset_mm, const person::Body& body,
                         linkage::WearOptions wear) {
  const linkage::UsedRange range = linkage::FindUsedRange(worn.links, worn.d_min_mm, worn.d_max_mm);
  const auto at = [&](const Vector2d& place) {
    wear.placement_mm = {place.x(), place.y()};
    wear.mount = worn.mount;
    return linkage::CheckWear(worn.links, range, body, wear);
  };
  WornJoint joint{.as_worn = at(offset_mm), .moved = at(Vector2d::Zero()), .nearest_mm = {}};
  const std::vector<Vector2d> places = PlacesAboutKnee(offset_mm.norm());
  const auto allowed =
      std::ranges::find_if(places, [&](const Vector2d& place) { return IsAllowed(at(place), joint.as_worn); });
  if (allowed != places.end()) joint.nearest_mm = *allowed;
  return joint;
}

std::string WornJointText(const WornJoint& joint, double unmoved_mm) {
  if (joint.nearest_mm && joint.nearest_mm->isZero())
    return joint.moved.meets_seat ? "Seat and limbs allow it: nothing reaches further into them than as worn."
                                  : "Mounted beside the leg, the linkage meets neither seat nor limbs there.";
  std::string text =
      fmt::format("Seat or leg is in the way of that: seen from the side, {}.", Collisions(joint.moved, joint.as_worn));
  if (!joint.moved.ClearsSeat())
    text += fmt::format(" A seat whose edge is at least {:.0f} mm behind the knee is clear of it.",
                        std::ceil(joint.moved.seat_edge_needed_mm));
  if (joint.nearest_mm)
    return text + fmt::format(
                      " The nearest place at which nothing reaches further than as worn is {}; it leaves {:.0f} mm RMS "
                      "between joint and knee.",
                      compare::DescribeJoint(*joint.nearest_mm), std::hypot(joint.nearest_mm->norm(), unmoved_mm));
  return text +
         fmt::format(
             " At every place nearer to the knee than as worn (and within {:.0f} mm of it) something reaches further.",
             kReach_mm);
}

Json WornJointJson(const WornJoint& joint) {
  Json json = {{"as_worn", ReachJson(joint.as_worn)}, {"moved", ReachJson(joint.moved)}, {"nearest_mm", nullptr}};
  if (const auto& nearest = joint.nearest_mm) json["nearest_mm"] = {nearest->x(), nearest->y()};
  return json;
}

}  // namespace lake::commands
