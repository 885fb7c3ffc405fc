#include "extras.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "random.h"

namespace lake {
namespace {

using Eigen::Vector2d;

constexpr double kTurn = 2 * std::numbers::pi;

double Clearance(const Vector2d& place, const MarkerPaths& paths) {
  double nearest = 1e9;
  for (const auto& markers : paths)
    for (const Vector2d& marker : markers) nearest = std::min(nearest, (marker - place).norm());
  return nearest;
}

// A place by lot that is at least `clear_px` from all paths and `inset` from the border.
Vector2d FreePlace(Random& random, const cv::Size& picture, const MarkerPaths& paths, double clear_px, double inset) {
  constexpr int kTries = 10000;
  for (int i = 0; i < kTries; ++i) {
    const Vector2d place(random.Uniform(inset, picture.width - 1 - inset),
                         random.Uniform(inset, picture.height - 1 - inset));
    if (Clearance(place, paths) > clear_px) return place;
  }
  throw Fail(
      "no room for reflections {:.0f} px away from the markers; show more of the room (a smaller marker radius in px)",
      clear_px);
}

}  // namespace

std::vector<Sprite> Reflections(const SceneOptions& options, const cv::Size& picture, const MarkerPaths& paths,
                                double radius_px) {
  Random random(options.seed, "reflections");
  std::vector<Sprite> sprites;
  for (int i = 0; i < options.reflections; ++i) {
    const bool streak = i % 2 == 1;
    const double width = radius_px * (streak ? random.Uniform(0.3, 0.5) : random.Uniform(0.7, 1.25));
    const double length = streak ? width * random.Uniform(4, 8) : width;
    const Vector2d place = FreePlace(random, picture, paths, 6 * radius_px + length, 8 * radius_px);
    const double level = options.marker_level * random.Uniform(0.7, 1.3);
    Sprite sprite{cv::Vec3f::all(static_cast<float>(level)), {}, {}};
    sprite.instants.push_back({EllipseOutline(place, length, width, random.Uniform(0, kTurn), 96), {}});
    sprites.push_back(sprite);
  }
  return sprites;
}

Glint::Glint(const SceneOptions& options, const cv::Size& picture, const MarkerPaths& paths, double radius_px)
    : radius_px_(radius_px), level_(options.marker_level) {
  Random random(options.seed, "glint");
  swing_ = radius_px * Vector2d(random.Uniform(8, 14), random.Uniform(4, 8));
  centre_ = FreePlace(random, picture, paths, 6 * radius_px + swing_.norm(), 8 * radius_px + swing_.norm());
  for (int i = 0; i < 3; ++i) hz_[i] = random.Uniform(0.2, 0.6), phase_rad_[i] = random.Uniform(0, kTurn);
}

Sprite Glint::At(const std::vector<double>& times_s) const {
  const auto wave = [this](int i, double t) { return std::sin(kTurn * hz_[i] * t + phase_rad_[i]); };
  const double shine = wave(2, times_s[times_s.size() / 2]);
  Sprite sprite{cv::Vec3f::all(static_cast<float>(level_ * (0.25 + 0.95 * shine * shine))), {}, {}};
  for (const double t : times_s) {
    const Vector2d place = centre_ + Vector2d(swing_.x() * wave(0, t), swing_.y() * wave(1, t));
    sprite.instants.push_back({EllipseOutline(place, 2.6 * radius_px_, 0.7 * radius_px_, 0.8 * wave(0, t)), {}});
  }
  return sprite;
}

std::vector<Layer> HandLayers(const Occlusion& occlusion, std::uint64_t seed, int index, double forward,
                              double marker_radius_mm, bool bright, double soft_px, const std::vector<double>& times_s,
                              const std::vector<Vector2d>& marker_mm) {
  constexpr double kHalfWidth = 42, kSweep = 330;  // mm; the sweep's length to either side of the marker
  // A tenth of the disc is hidden when the hand's edge has passed 0.31 radii into it.
  const double speed = 2 * (kHalfWidth + (1 - 0.313) * marker_radius_mm) / occlusion.hidden_s;
  const double middle = occlusion.start_s + 0.5 * occlusion.hidden_s;
  if (std::abs(times_s[times_s.size() / 2] - middle) * speed > kSweep) return {};
  Random random(seed, "hand", static_cast<std::uint64_t>(index));
  const bool from_front = occlusion.marker == "ankle" || occlusion.marker == "knee" || occlusion.marker == "exo_knee";
  const double tilt = RadiansFromDegrees(random.Uniform(-18, 18)), side = (from_front ? -1 : 1) * forward;
  const double up_or_down = random.Uniform() < 0.5 ? -1 : 1;
  const Vector2d point(side * std::cos(tilt), std::sin(tilt)),
      across(-point.y(), point.x());  // to the fingertips; the sweep
  const cv::Vec3f skin = bright ? cv::Vec3f(150, 172, 205) : cv::Vec3f(92, 116, 162);
  const cv::Vec3f cloth = bright ? cv::Vec3f(190, 170, 160) : cv::Vec3f(96, 66, 48);
  Layer sleeve{{cloth, nullptr, 0, 1, 0.3f}, {}, soft_px}, hand{{skin, nullptr, 0, 1, 0.25f}, {}, soft_px};
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    const double swept = (times_s[i] - middle) * speed;
    const double withdrawn = 80 * (swept / 150) * (swept / 150);
    const Vector2d palm = marker_mm[i] + up_or_down * swept * across - withdrawn * point;
    const auto at = [&](double along, double aside) { return Vector2d(palm + along * point + aside * across); };
    sleeve.instants.push_back({Capsule(at(-190, 0), at(-1800, 0), 38, 70), palm, point, 50});
    hand.instants.push_back(
        {{at(-175, -28), at(-75, -32), at(-55, -kHalfWidth), at(48, -kHalfWidth), at(80, -36), at(92, -25), at(99, -10),
          at(98, 8), at(92, 24), at(78, 36), at(48, kHalfWidth), at(-55, kHalfWidth), at(-75, 32), at(-175, 28)},
         palm,
         point,
         kHalfWidth});
  }
  return {sleeve, hand};
}

}  // namespace lake
