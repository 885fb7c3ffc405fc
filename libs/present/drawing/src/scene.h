// A drawing in mm with equal axes, as one panel of a gnuplot figure: filled shapes, strokes and labels, drawn in the
// order given (labels on top).
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "lake/core/colours.h"
#include "lake/figure/gnuplot.h"

namespace lake::drawing {

using PlanePath = std::vector<Eigen::Vector2d>;

struct SceneView {
  double left, right, bottom, top;
};

struct LabelStyle {
  std::string colour = colour::kText;
  std::string align = "center";  // left, center, right
  int size = 13;
  bool box = true;  // on a white ground
};

class Scene {
 public:
  explicit Scene(figure::GnuplotFigure& figure) : figure_(figure) {}

  void Fill(const PlanePath& outline, std::string_view colour);
  void Stroke(const PlanePath& path, std::string_view colour, double width, std::string_view dash = "solid");
  // Text in gnuplot's enhanced markup.
  void Label(const Eigen::Vector2d& at, std::string_view text, const LabelStyle& style = {});
  // A pin seen from its end.
  void Pin(const Eigen::Vector2d& at, double size = 1);

  // Draws into the part of the page (fractions: left, bottom, width, height) and forgets its labels.
  struct Place {
    double left, bottom, width, height;
  };
  void Draw(const SceneView& view, const Place& place, bool axes = true);

 private:
  enum class Kind { kFill, kStroke, kPin };
  struct Shape {
    Kind kind;
    PlanePath path;
    std::string style;  // how gnuplot is to draw it
  };

  figure::GnuplotFigure& figure_;
  std::vector<Shape> shapes_;
  int labels_ = 0;
};

// Outline of a bar with round ends, of the given radii.
PlanePath CapsulePath(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double from_radius, double to_radius);
PlanePath Arc(const Eigen::Vector2d& centre, double radius, double from_rad,
              double to_rad);  // counter-clockwise from +x
PlanePath Circle(const Eigen::Vector2d& centre, double radius);

// The part of a closed outline that lies in the view (Sutherland & Hodgman 1974).
PlanePath ClippedTo(const SceneView& view, PlanePath outline);

// Cuts the corners of a closed outline (Chaikin), a few times over.
PlanePath Rounded(PlanePath outline);

}  // namespace lake::drawing
