// The clothed person and the exoskeleton, as layers around the markers.
#pragma once

#include <functional>
#include <optional>

#include "layer.h"

namespace lake::synth {

// Where the body is at one instant, mm in the plane frame; what is not marked is not drawn.
struct BodyPose {
  std::optional<Eigen::Vector2d> ankle, knee, hip, waist, exo_knee;
  std::optional<double> foot_rad;  // of the sole above the direction in which the person looks
};

struct Wardrobe {
  Texture denim, knit;  // trousers and shirt
  explicit Wardrobe(std::uint64_t seed);
};

// The leg alone, from back to front.
std::vector<Layer> LegLayers(const std::vector<BodyPose>& instants, const Wardrobe& wardrobe, bool is_bright,
                             double forward);

// The trunk and the leg, from back to front. `forward` is +1 when the subject faces right, −1 left. The wardrobe must
// outlive the layers.
std::vector<Layer> BodyLayers(const std::vector<BodyPose>& instants, const Wardrobe& wardrobe, double forward,
                              bool bright_clothes);

// Links, joint, straps and actuator; nothing without exo_knee, ankle and hip.
std::vector<Layer> ExoskeletonLayers(const std::vector<BodyPose>& instants, double forward);

// A disc on the exoskeleton's joint; `shown` is where a point at its depth is seen in the plane.
std::vector<Layer> HubLayers(const std::vector<BodyPose>& instants, double radius_mm,
                             const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& shown);

inline constexpr double kSoleBelowAnkle = 85;  // mm
inline constexpr double kThighRadiusAtHip = 90;

}  // namespace lake::synth
