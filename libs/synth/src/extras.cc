#include "extras.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "random.h"

namespace lake::synth {
namespace {

using Eigen::Vector2d;

constexpr double kTurn = 2 * std::numbers::pi;

double Clearance(const Vector2d& place, const MarkerPaths& paths) {
  double nearest = 1e9;
  for (const auto& markers : paths.px)
    for (const Vector2d& marker : markers) nearest = std::min(nearest, (marker - place).norm());
  return nearest;
}

// A place by lot that is clear of all paths by `extra_px` more, and `inset` from the border.
Vector2d FreePlace(Random& random, const cv::Size& picture, const MarkerPaths& paths, double extra_px, double inset) {
  constexpr int kTries = 10000;
  const double clear_px = paths.clear_px + extra_px;
  for (int i = 0; i < kTries; ++i) {
    const Vector2d place(random.Uniform(inset, picture.width - 1 - inset),
                         random.Uniform(inset, picture.height - 1 - inset));
    if (Clearance(place, paths) > clear_px) return place;
  }
  throw Fail("no room for reflections {:.0f} px away from the markers; show more of the room (smaller markers in px)",
             clear_px);
}

}  // namespace

std::vector<Sprite> Reflections(const SceneOptions& options, const cv::Size& picture, const MarkerPaths& paths) {
  Random random(options.seed, "reflections");
  const double radius_px = paths.radius_px;
  std::vector<Sprite> sprites;
  for (int i = 0; i < options.reflections; ++i) {
    const bool streak = i % 2 == 1;
    const double width = radius_px * (streak ? random.Uniform(0.3, 0.5) : random.Uniform(0.7, 1.25));
    const double length = streak ? width * random.Uniform(4, 8) : width;
    const Vector2d place = FreePlace(random, picture, paths, length, 8 * radius_px);
    const double level = options.marker_level * random.Uniform(0.7, 1.3);
    Sprite sprite{cv::Vec3f::all(static_cast<float>(level)), {}, {}};
    sprite.instants.push_back({EllipseOutline(place, length, width, random.Uniform(0, kTurn), 96), {}});
    sprites.push_back(sprite);
  }
  return sprites;
}

Glint::Glint(const SceneOptions& options, const cv::Size& picture, const MarkerPaths& paths)
    : radius_px_(paths.radius_px), level_(options.marker_level) {
  Random random(options.seed, "glint");
  swing_ = radius_px_ * Vector2d(random.Uniform(8, 14), random.Uniform(4, 8));
  centre_ = FreePlace(random, picture, paths, swing_.norm(), 8 * radius_px_ + swing_.norm());
  for (int i = 0; i < 3; ++i) {
    hz_[i] = random.Uniform(0.2, 0.6);
    phase_rad_[i] = random.Uniform(0, kTurn);
  }
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

namespace {

constexpr double kHandHalfWidth = 42, kHandLength = 99;  // mm; the length from the palm's middle to the fingertips
constexpr double kSweep = 380;                           // mm to either side of the marker, then it is out of sight

}  // namespace

Hand::Hand(const SceneOptions& options, std::size_t occlusion, const MarkerMotion& motion, double soft_px)
    : motion_(motion), soft_px_(soft_px), bright_(options.bright_room) {
  const Occlusion& asked = options.occlusions[occlusion];
  const int marker = IndexOfMarker(motion, asked.marker);
  if (marker < 0) throw UsageError("no marker '{}' to hide", asked.marker);
  marker_ = static_cast<std::size_t>(marker);
  // A tenth of the disc is hidden when the hand's edge has passed 0.31 radii into it.
  mm_per_s_ = 2 * (kHandHalfWidth + (1 - 0.313) * options.marker_radius_mm) / asked.hidden_s;
  middle_s_ = asked.start_s + 0.5 * asked.hidden_s;
  Random random(options.seed, "hand", occlusion);
  int fewest = std::numeric_limits<int>::max();
  constexpr int kTries = 24;
  for (int i = 0; i < kTries && fewest > 0; ++i) {
    const double side = random.Uniform() < 0.5 ? 0 : std::numbers::pi,
                 tilt = RadiansFromDegrees(random.Uniform(-25, 25));
    const Vector2d point(std::cos(side + tilt), std::sin(side + tilt));
    const double turn = random.Uniform() < 0.5 ? -1 : 1;
    const Approach approach{point, turn * Vector2d(-point.y(), point.x())};
    const int hidden = OthersHidden(approach);
    if (hidden < fewest) {
      fewest = hidden;
      approach_ = approach;
    }
  }
}

Vector2d Hand::Palm(const Approach& approach, double time_s) const {
  const double swept = (time_s - middle_s_) * mm_per_s_, withdrawn = 90 * (swept / 100) * (swept / 100);
  return motion_.At(time_s)[marker_] + swept * approach.sweep - withdrawn * approach.point;
}

// In how many hundredths of a second, summed over the other markers, one of them lies under hand or arm.
int Hand::OthersHidden(const Approach& approach) const {
  constexpr double kClear = 12;  // mm, more than a marker's radius
  constexpr double kArmHalfWidth = 70;
  int hidden = 0;
  for (double t = middle_s_ - kSweep / mm_per_s_; t < middle_s_ + kSweep / mm_per_s_; t += 0.01) {
    const std::vector<Vector2d> markers = motion_.At(t);
    const Vector2d palm = Palm(approach, t);
    for (std::size_t m = 0; m < markers.size(); ++m) {
      if (m == marker_) continue;
      const double along = (markers[m] - palm).dot(approach.point),
                   aside = std::abs((markers[m] - palm).dot(approach.sweep));
      hidden += along < kHandLength + kClear && aside < (along < -180 ? kArmHalfWidth : kHandHalfWidth) + kClear;
    }
  }
  return hidden;
}

std::vector<Layer> Hand::At(const std::vector<double>& times_s) const {
  if (std::abs(times_s[times_s.size() / 2] - middle_s_) * mm_per_s_ > kSweep) return {};
  const cv::Vec3f skin = bright_ ? cv::Vec3f(150, 172, 205) : cv::Vec3f(92, 116, 162);
  const cv::Vec3f cloth = bright_ ? cv::Vec3f(190, 170, 160) : cv::Vec3f(96, 66, 48);
  Layer sleeve{{cloth, nullptr, 0, 1, 0.3f}, {}, soft_px_}, hand{{skin, nullptr, 0, 1, 0.25f}, {}, soft_px_};
  Layer gaps{{0.72f * skin, nullptr, 0, 1, 0}, {}, soft_px_};
  for (const double time : times_s) {
    const Vector2d palm = Palm(approach_, time), &point = approach_.point, &across = approach_.sweep;
    const auto at = [&](double along, double aside) { return Vector2d(palm + along * point + aside * across); };
    sleeve.instants.push_back({Capsule(at(-190, 0), at(-1800, 0), 38, 70), palm, point, 50});
    const double w = kHandHalfWidth;
    hand.instants.push_back(
        {{at(-175, -28), at(-75, -32), at(-55, -w), at(48, -w), at(80, -36), at(92, -25), at(kHandLength, -10),
          at(98, 8), at(92, 24), at(78, 36), at(48, w), at(-55, w), at(-75, 32), at(-175, 28)},
         palm,
         point,
         w});
    // One outline around the three gaps between the fingers, as they are joined by the palm's crease.
    gaps.instants.push_back({{at(8, -23), at(84, -23), at(84, -20), at(10, -20), at(10, -2), at(92, -2), at(92, 1),
                              at(10, 1), at(10, 19), at(84, 19), at(84, 22), at(8, 22)},
                             palm,
                             point,
                             w});
  }
  return {sleeve, hand, gaps};
}

}  // namespace lake::synth
