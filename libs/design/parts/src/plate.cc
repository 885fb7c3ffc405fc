#include "lake/parts/plate.h"

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>

namespace lake::parts {
namespace {

using Eigen::Vector2d;

Vector2d AtHeading(double angle_rad) {
  return {std::cos(angle_rad), std::sin(angle_rad)};
}

// Integrals over an area: 1, x, y, x^2, y^2, xy.
using Moments = Eigen::Matrix<double, 6, 1>;

// Their share of a point of the boundary that moves by `step`, by Green's theorem.
Moments BoundaryTerm(const Vector2d& at, const Vector2d& step) {
  const double x = at.x(), y = at.y(), dx = step.x(), dy = step.y();
  Moments terms;
  terms << (x * dy - y * dx) / 2, x * x * dy / 2, -y * y * dx / 2, x * x * x * dy / 3, -y * y * y * dx / 3,
      x * x * y * dy / 2;
  return terms;
}

// Gauss's rule is exact for a line, and for an arc to rounding.
template <typename Curve>
Moments Integrate(const Curve& term) {
  Moments sum = Moments::Zero();
  using Rule = boost::math::quadrature::gauss<double, 30>;
  for (std::size_t i = 0; i < Rule::abscissa().size(); ++i)
    for (const double side : {-1.0, 1.0}) sum += Rule::weights()[i] / 2 * term(0.5 + 0.5 * side * Rule::abscissa()[i]);
  return sum;
}

Moments MomentsOf(const OutlinePiece& piece) {
  if (!piece.is_arc)
    return Integrate([&](double t) {
      const Vector2d along = piece.to - piece.from;
      return BoundaryTerm(piece.from + t * along, along);
    });
  const double radius = (piece.from - piece.centre).norm(), turn = piece.to_rad - piece.from_rad;
  return Integrate([&](double t) {
    const Vector2d out = radius * AtHeading(piece.from_rad + t * turn);
    return BoundaryTerm(piece.centre + out, turn * Vector2d(-out.y(), out.x()));
  });
}

Moments MomentsOf(const Hole& hole) {
  const double r2 = hole.diameter_mm * hole.diameter_mm / 4, area = std::numbers::pi * r2;
  const double x = hole.at_mm.x(), y = hole.at_mm.y();
  Moments moments;
  moments << area, area * x, area * y, area * (x * x + r2 / 4), area * (y * y + r2 / 4), area * x * y;
  return moments;
}

}  // namespace

std::vector<OutlinePiece> OutlineOf(const Plate& plate) {
  const std::size_t count = plate.corners.size();
  std::vector<double> outward_rad(count);  // direction of the normal of the side that starts at each corner
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2d side = plate.corners[(i + 1) % count] - plate.corners[i];
    outward_rad[i] = std::atan2(-side.x(), side.y());
  }
  std::vector<OutlinePiece> pieces;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2d& corner = plate.corners[i];
    const Vector2d& next = plate.corners[(i + 1) % count];
    const double before_rad = outward_rad[(i + count - 1) % count];
    double after_rad = outward_rad[i];
    while (after_rad < before_rad) after_rad += 2 * std::numbers::pi;
    const Vector2d out = plate.radius_mm * AtHeading(outward_rad[i]);
    pieces.push_back(
        {corner + plate.radius_mm * AtHeading(before_rad), corner + out, true, corner, before_rad, after_rad});
    pieces.push_back({corner + out, next + out});
  }
  return pieces;
}

PlateMass MassOf(const Plate& plate) {
  Moments moments = Moments::Zero();
  for (const OutlinePiece& piece : OutlineOf(plate)) moments += MomentsOf(piece);
  for (const Hole& hole : plate.holes) moments -= MomentsOf(hole);
  constexpr double kCubicMillimetresPerCubicMetre = 1e9;
  const double per_area = plate.density_kg_m3 * plate.thickness_mm / kCubicMillimetresPerCubicMetre;
  PlateMass mass{
      .area_mm2 = moments[0], .mass_kg = per_area * moments[0], .centre_mm = moments.segment<2>(1) / moments[0]};
  const Vector2d& c = mass.centre_mm;
  const double through = mass.mass_kg * plate.thickness_mm * plate.thickness_mm / 12;
  const double about_y = per_area * moments[3] - mass.mass_kg * c.x() * c.x();
  const double about_x = per_area * moments[4] - mass.mass_kg * c.y() * c.y();
  mass.xx_kg_mm2 = about_x + through;
  mass.yy_kg_mm2 = about_y + through;
  mass.zz_kg_mm2 = about_x + about_y;
  mass.xy_kg_mm2 = -(per_area * moments[5] - mass.mass_kg * c.x() * c.y());
  return mass;
}

}  // namespace lake::parts
