// Where labels go in a scene, so that they cover neither its lines nor each other and stay within it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "label_places.h"
#include "scene.h"

namespace lake::drawing {

// What a label belongs to: a point, and which way from it the label is to stand (length 1).
struct LabelSpot {
  Eigen::Vector2d at, outward;
};

// Round a point, the first way first; on both sides of a line, beside its middle first (`side` 1: first on its right
// as one goes along it, -1: left).
std::vector<LabelSpot> RoundPoint(const Eigen::Vector2d& at, const Eigen::Vector2d& first);
std::vector<LabelSpot> BesideLine(const Eigen::Vector2d& from, const Eigen::Vector2d& to, int side);

struct LabelWish {
  std::string name;  // by which its place is found again
  std::vector<LabelSpot> spots;
  std::size_t letters;
};

class LabelRoom {
 public:
  // `scale`: mm per px of the scene's PNG, in which text is larger than in its SVG.
  LabelRoom(const SceneView& view, double scale) : view_(view), scale_(scale) {}

  // What labels must not cover; `weight` below 1: what they may where there is no other room.
  void Avoid(const PlanePath& path, double half_width_mm, double weight = 1);

  // The labels' centres. Those whose place in the picture before is free stay there; then the others go as near to one
  // of their spots, and to that place, as there is room, in steps of `gap_mm`. `places`: of the picture before, then
  // of this one.
  std::vector<Eigen::Vector2d> Place(const std::vector<LabelWish>& wishes, double gap_mm, LabelPlaces& places);

 private:
  struct Box {
    Eigen::Array2d low, high;
  };
  struct Line {
    Eigen::Vector2d from, to;
    double half_width_mm, weight;
  };

  Box BoxAt(const LabelWish& wish, double gap_mm, const LabelPlace& place) const;
  double Covered(const Box& label) const;
  // `before`: where it would stand if it stayed.
  LabelPlace BestPlace(const LabelWish& wish, double gap_mm, const std::optional<Box>& before) const;

  SceneView view_;
  double scale_;
  std::vector<Box> taken_;
  std::vector<Line> lines_;
};

}  // namespace lake::drawing
