#include "scene.h"

#include <fmt/format.h>

#include <cmath>

#include "lake/core/numbers.h"

namespace lake::drawing {
namespace {

using Eigen::Vector2d;

std::vector<std::vector<double>> Columns(const PlanePath& path) {
  std::vector<std::vector<double>> columns(2);
  for (const Vector2d& point : path) {
    columns[0].push_back(point.x());
    columns[1].push_back(point.y());
  }
  return columns;
}

}  // namespace

void Scene::Fill(const PlanePath& outline, std::string_view colour) {
  shapes_.push_back(
      {Kind::kFill, outline, fmt::format("with filledcurves closed fc rgb '{}' fs solid noborder", colour)});
}

void Scene::Stroke(const PlanePath& path, std::string_view colour, double width, std::string_view dash) {
  const std::string pattern = dash == "solid" ? "dt 1" : dash == "dotted" ? "dt 3" : "dt (8,5)";
  shapes_.push_back({Kind::kStroke, path, fmt::format("with lines lc rgb '{}' lw {} {}", colour, width, pattern)});
}

void Scene::Label(const Vector2d& at, std::string_view text, const LabelStyle& style) {
  figure_.Line("set label {} {} at first {},{} {} front {} textcolor rgb '{}' font ',{}'", ++labels_,
               figure::QuoteForGnuplot(text), at.x(), at.y(), style.align, style.box ? "boxed" : "", style.colour,
               style.size);
}

void Scene::Pin(const Vector2d& at, double size) {
  shapes_.push_back({Kind::kPin, {at}, fmt::format("with points pt 7 ps {} lc rgb '#222222'", 1.5 * size)});
  shapes_.push_back({Kind::kPin, {at}, fmt::format("with points pt 7 ps {} lc rgb '#ffffff'", 0.7 * size)});
}

void Scene::Draw(const SceneView& view, const Place& place, bool axes) {
  // A line that crosses the picture is drawn though both its ends lie outside.
  figure_.Line(
      "set size ratio -1\nset clip two\nset style textbox opaque noborder fillcolor rgb '#ffffff' margins 0.6,0.4");
  figure_.Line("set lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen {}\nset tmargin at screen {}",
               place.left, place.left + place.width, place.bottom, place.bottom + place.height);
  figure_.Line("set xrange [{}:{}]\nset yrange [{}:{}]", view.left, view.right, view.bottom, view.top);
  figure_.Line(axes ? fmt::format("set tics out nomirror font ',11'\nset border 3 lc rgb '#666666'\nset xlabel 'mm' "
                                  "offset 0,0.3\nset ylabel 'mm' offset 1,0\nset grid lc rgb '{}' lt 1",
                                  colour::kGrid)
                    : "unset tics\nunset border\nunset xlabel\nunset ylabel\nunset grid");
  std::string elements;
  for (const Shape& shape : shapes_) {
    const PlanePath path = shape.kind == Kind::kFill ? ClippedTo(view, shape.path) : shape.path;
    if (path.empty()) continue;
    elements += fmt::format("{}{} {} notitle", elements.empty() ? "" : ", ", figure_.Data(Columns(path)), shape.style);
  }
  figure_.Line("plot " + elements);
  for (; labels_ > 0; --labels_) figure_.Line("unset label {}", labels_);
  shapes_.clear();
}

PlanePath Arc(const Vector2d& centre, double radius, double from_rad, double to_rad) {
  const int steps = std::max(2, static_cast<int>(std::ceil(std::abs(to_rad - from_rad) / 0.08)));
  PlanePath path;
  for (int i = 0; i <= steps; ++i) {
    const double angle = from_rad + (to_rad - from_rad) * i / steps;
    path.push_back(centre + radius * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return path;
}

PlanePath Circle(const Vector2d& centre, double radius) {
  return Arc(centre, radius, 0, 2 * kPi);
}

PlanePath CapsulePath(const Vector2d& from, const Vector2d& to, double from_radius, double to_radius) {
  const Vector2d along = to - from;
  const double length = along.norm();
  if (length <= std::abs(from_radius - to_radius))
    return from_radius > to_radius ? Circle(from, from_radius) : Circle(to, to_radius);
  const double heading = std::atan2(along.y(), along.x()), tangent = std::acos((from_radius - to_radius) / length);
  PlanePath outline = Arc(to, to_radius, heading - tangent, heading + tangent);
  const PlanePath back = Arc(from, from_radius, heading + tangent, heading + 2 * kPi - tangent);
  outline.insert(outline.end(), back.begin(), back.end());
  outline.push_back(outline.front());
  return outline;
}

PlanePath ClippedTo(const SceneView& view, PlanePath outline) {
  struct Edge {
    Vector2d inward;
    double offset;
  };
  for (const Edge& edge :
       {Edge{{1, 0}, view.left}, Edge{{-1, 0}, -view.right}, Edge{{0, 1}, view.bottom}, Edge{{0, -1}, -view.top}}) {
    PlanePath kept;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vector2d& here = outline[i];
      const Vector2d& next = outline[(i + 1) % outline.size()];
      const double inside = edge.inward.dot(here) - edge.offset, next_inside = edge.inward.dot(next) - edge.offset;
      if (inside >= 0) kept.push_back(here);
      if ((inside >= 0) != (next_inside >= 0)) kept.push_back(here + inside / (inside - next_inside) * (next - here));
    }
    outline = std::move(kept);
  }
  return outline;
}

PlanePath Rounded(PlanePath outline) {
  for (int pass = 0; pass < 4; ++pass) {
    PlanePath cut;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vector2d& here = outline[i];
      const Vector2d& next = outline[(i + 1) % outline.size()];
      cut.push_back(0.75 * here + 0.25 * next);
      cut.push_back(0.25 * here + 0.75 * next);
    }
    outline = std::move(cut);
  }
  outline.push_back(outline.front());
  return outline;
}

}  // namespace lake::drawing
