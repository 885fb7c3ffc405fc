#include "body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>

namespace lake::synth {
namespace {

using Eigen::Vector2d;

Vector2d Across(const Vector2d& axis) {
  return {axis.y(), -axis.x()};
}

Layer MakeLayer(const std::vector<BodyPose>& instants, const Surface& surface,
                const std::function<Shape(const BodyPose&)>& shape) {
  Layer layer{surface, {}, 0};
  for (const BodyPose& pose : instants) layer.instants.push_back(shape(pose));
  return layer;
}

Shape Limb(const Vector2d& from, const Vector2d& to, double from_radius, double to_radius) {
  return {.outline = Capsule(from, to, from_radius, to_radius),
          .origin = from,
          .axis = (to - from).normalized(),
          .half_width = std::max(from_radius, to_radius)};
}

// A place on the trunk: `up` along hip–waist, `front` towards where the person looks. A waist marker that is as high as
// a shoulder stretches the trunk, so that it is on it.
Vector2d OnTrunk(const BodyPose& pose, double forward, double up, double front) {
  constexpr double kShoulder = 430;
  const Vector2d trunk = *pose.waist - *pose.hip, axis = trunk.normalized();
  return *pose.hip + up * std::max(1.0, trunk.norm() / kShoulder) * axis + forward * front * Across(axis);
}

struct Clothes {
  Surface skin, hair, shirt, trousers, shoe, sole;
};

Clothes Dress(const Wardrobe& wardrobe, bool bright) {
  if (bright)
    return {.skin = {{140, 165, 200}, nullptr, 0, 1, 0.2f},
            .hair = {{105, 110, 115}, &wardrobe.knit, 0.08f, 1.5f, 0.1f},
            .shirt = {{195, 190, 182}, &wardrobe.knit, 0.03f, 1.6f, 0.12f},
            .trousers = {{172, 170, 168}, &wardrobe.denim, 0.04f, 1.4f, 0.15f},
            .shoe = {{150, 150, 150}, &wardrobe.knit, 0.03f, 1, 0.1f},
            .sole = {{120, 120, 120}, nullptr, 0, 1, 0}};
  return {.skin = {{95, 118, 165}, nullptr, 0, 1, 0.3f},
          .hair = {{22, 26, 30}, &wardrobe.knit, 0.2f, 1.5f, 0.2f},
          .shirt = {{62, 52, 44}, &wardrobe.knit, 0.10f, 1.6f, 0.4f},
          .trousers = {{38, 28, 24}, &wardrobe.denim, 0.16f, 1.4f, 0.45f},
          .shoe = {{52, 50, 48}, &wardrobe.knit, 0.10f, 1, 0.2f},
          .sole = {{104, 106, 108}, nullptr, 0, 1, 0}};
}

void AddTrunk(const std::vector<BodyPose>& instants, const Clothes& wear, double forward, std::vector<Layer>& layers) {
  const auto at = [forward](const BodyPose& pose, double up, double front) {
    return OnTrunk(pose, forward, up, front);
  };
  layers.push_back(
      MakeLayer(instants, wear.skin, [&](const auto& p) { return Limb(at(p, 480, 5), at(p, 590, 25), 58, 52); }));
  layers.push_back(
      MakeLayer(instants, wear.hair, [&](const auto& p) { return Limb(at(p, 640, 10), at(p, 720, 20), 92, 96); }));
  layers.push_back(
      MakeLayer(instants, wear.skin, [&](const auto& p) { return Limb(at(p, 620, 55), at(p, 680, 60), 62, 70); }));
  layers.push_back(
      MakeLayer(instants, wear.shirt, [&](const auto& p) { return Limb(at(p, 20, 0), at(p, 430, 5), 118, 112); }));
  // The arm is folded over the chest, above the waist marker.
  Surface sleeve = wear.shirt;
  sleeve.bgr *= 0.85f;
  layers.push_back(
      MakeLayer(instants, sleeve, [&](const auto& p) { return Limb(at(p, 455, 0), at(p, 300, 70), 58, 46); }));
  layers.push_back(
      MakeLayer(instants, sleeve, [&](const auto& p) { return Limb(at(p, 300, 70), at(p, 385, 170), 45, 36); }));
  layers.push_back(
      MakeLayer(instants, wear.skin, [&](const auto& p) { return Limb(at(p, 395, 180), at(p, 425, 200), 34, 30); }));
}

Polygon Shoe(const BodyPose& pose, double forward, double top, double bottom) {
  const Eigen::Rotation2Dd turn(forward * pose.foot_rad.value_or(0));
  Polygon outline;
  const double profile[][2] = {{-72, bottom},
                               {185, bottom},
                               {192, std::min(top, bottom + 22.0)},
                               {170, std::min(top, -42.0)},
                               {110, std::min(top, -20.0)},
                               {55, std::min(top, 12.0)},
                               {40, top},
                               {-55, top},
                               {-70, std::min(top, -15.0)}};
  for (const auto& [x, y] : profile) outline.push_back(*pose.ankle + turn * Vector2d(forward * x, y));
  return outline;
}

}  // namespace

Wardrobe::Wardrobe(std::uint64_t seed) : denim(seed, "denim", 0.8, 14, 0.6), knit(seed, "knit", 1.2, 20, 0.5) {}

std::vector<Layer> LegLayers(const std::vector<BodyPose>& instants, const Wardrobe& wardrobe, bool is_bright,
                             double forward) {
  const Clothes wear = Dress(wardrobe, is_bright);
  const BodyPose& first = instants.front();
  std::vector<Layer> layers;
  if (first.knee && first.hip)
    layers.push_back(
        MakeLayer(instants, wear.trousers, [](const auto& p) { return Limb(*p.hip, *p.knee, kThighRadiusAtHip, 62); }));
  if (first.ankle) {
    layers.push_back(MakeLayer(instants, wear.sole, [&](const auto& p) {
      return Shape{Shoe(p, forward, -55, -kSoleBelowAnkle), *p.ankle};
    }));
    layers.push_back(MakeLayer(instants, wear.shoe, [&](const auto& p) {
      return Shape{
          .outline = Shoe(p, forward, 25, -68), .origin = *p.ankle, .axis = Vector2d::UnitX(), .half_width = 400};
    }));
  }
  if (first.ankle && first.knee)
    layers.push_back(MakeLayer(instants, wear.trousers, [](const auto& p) { return Limb(*p.knee, *p.ankle, 62, 44); }));
  return layers;
}

std::vector<Layer> BodyLayers(const std::vector<BodyPose>& instants, const Wardrobe& wardrobe, double forward,
                              bool bright_clothes) {
  std::vector<Layer> layers;
  if (instants.front().hip && instants.front().waist)
    AddTrunk(instants, Dress(wardrobe, bright_clothes), forward, layers);
  for (Layer& layer : LegLayers(instants, wardrobe, bright_clothes, forward)) layers.push_back(std::move(layer));
  return layers;
}

std::vector<Layer> ExoskeletonLayers(const std::vector<BodyPose>& instants, double forward) {
  const BodyPose& first = instants.front();
  std::vector<Layer> layers;
  if (!first.exo_knee || !first.ankle || !first.hip) return layers;
  const Surface aluminium{
      .bgr = {118, 116, 112}, .texture = nullptr, .contrast = 0, .mm_per_texel = 1, .rounding = 0.35f},
      black{{24, 24, 24}, nullptr, 0, 1, 0.2f}, cylinder{{60, 58, 92}, nullptr, 0, 1, 0.5f};
  struct Links {
    Vector2d knee, thigh, thigh_end, shank, shank_end;  // directions of the bars and where they end
  };
  const auto links = [](const BodyPose& p) {
    const Vector2d thigh = (*p.hip - *p.exo_knee).normalized(), shank = (*p.ankle - *p.exo_knee).normalized();
    return Links{*p.exo_knee, thigh, *p.exo_knee + 0.8 * (*p.hip - *p.exo_knee), shank,
                 *p.exo_knee + 0.8 * (*p.ankle - *p.exo_knee)};
  };
  const auto add = [&](const Surface& surface, const std::function<Shape(const Links&)>& shape) {
    layers.push_back(MakeLayer(instants, surface, [&](const BodyPose& p) { return shape(links(p)); }));
  };
  const auto strap = [](const Vector2d& middle, const Vector2d& along, double half_width) {
    const Vector2d across = Across(along);
    return Shape{.outline = {middle - half_width * across - 18 * along, middle + half_width * across - 18 * along,
                             middle + half_width * across + 18 * along, middle - half_width * across + 18 * along},
                 .origin = middle,
                 .axis = along,
                 .half_width = half_width};
  };
  add(black, [&](const Links& l) { return strap(l.knee + 0.62 * (l.thigh_end - l.knee), l.thigh, 74); });
  add(black, [&](const Links& l) { return strap(l.knee + 0.68 * (l.shank_end - l.knee), l.shank, 54); });
  // The actuator lies behind the thigh bar, as in the paper: from a mount near its end to a bar above the knee.
  const auto behind = [forward](const Links& l, double part, double offset) {
    return Vector2d(l.knee + part * (l.thigh_end - l.knee) + forward * offset * Across(l.thigh));
  };
  add(cylinder, [&](const Links& l) { return Limb(behind(l, 0.95, -62), behind(l, 0.45, -60), 15, 15); });
  add(black, [&](const Links& l) { return Limb(behind(l, 0.45, -60), behind(l, 0.16, -48), 6, 6); });
  add(aluminium, [&](const Links& l) { return Limb(l.knee, l.thigh_end, 13, 13); });
  add(aluminium, [&](const Links& l) { return Limb(l.knee, l.shank_end, 12, 12); });
  add(aluminium, [&](const Links& l) {
    return Shape{
        .outline = EllipseOutline(l.knee, 21, 21, 0), .origin = l.knee, .axis = Vector2d::UnitX(), .half_width = 21};
  });
  return layers;
}

std::vector<Layer> HubLayers(const std::vector<BodyPose>& instants, double radius_mm,
                             const std::function<Vector2d(const Vector2d&)>& shown) {
  if (!instants.front().exo_knee) return {};
  const Surface black{.bgr = {30, 30, 32}, .texture = nullptr, .contrast = 0, .mm_per_texel = 1, .rounding = 0.3f};
  return {MakeLayer(instants, black, [&](const BodyPose& pose) {
    Shape disc{.outline = EllipseOutline(*pose.exo_knee, radius_mm, radius_mm, 0),
               .origin = shown(*pose.exo_knee),
               .half_width = radius_mm};
    for (Vector2d& corner : disc.outline) corner = shown(corner);
    return disc;
  })};
}

}  // namespace lake::synth
