// Outline, area and inertia of plates, by hand and against sums over a fine grid.
#include "lake/parts/plate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace lake {
namespace {

using Eigen::Vector2d;

parts::Plate BarOf(double length, double radius) {
  parts::Plate plate;
  plate.corners = {{0, 0}, {length, 0}};
  plate.radius_mm = radius;
  plate.thickness_mm = 4;
  plate.density_kg_m3 = 2700;
  return plate;
}

TEST(Plates, OutlineIsClosedSmoothAndAnticlockwise) {
  parts::Plate plate = BarOf(60, 12);
  plate.corners = {{0, 0}, {118, 343}, {0, 56}};
  const auto outline = parts::OutlineOf(plate);
  ASSERT_EQ(outline.size(), 6u);
  double turn = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const parts::OutlinePiece& next = outline[(i + 1) % outline.size()];
    EXPECT_NEAR((outline[i].to - next.from).norm(), 0, 1e-12);
    if (outline[i].is_arc) {
      EXPECT_GT(outline[i].to_rad, outline[i].from_rad);
      turn += outline[i].to_rad - outline[i].from_rad;
    }
  }
  EXPECT_NEAR(turn, 2 * std::numbers::pi, 1e-12);
}

// A stadium with two holes by hand.
TEST(Plates, MassOfABar) {
  parts::Plate plate = BarOf(60, 12);
  const double stadium = 60 * 24 + std::numbers::pi * 144;
  EXPECT_NEAR(parts::MassOf(plate).area_mm2, stadium, 1e-10);
  // About its own centre: a rectangle, and two half discs as one disc pulled apart by 60 mm.
  const double disc = std::numbers::pi * 144, half_disc_offset = 30;
  const double xx = 60 * std::pow(24, 3) / 12 + disc * 144 / 4;
  const double half_centroid = 4 * 12 / (3 * std::numbers::pi);
  const double yy = 24 * std::pow(60, 3) / 12 + disc * 144 / 4 + disc * half_disc_offset * half_disc_offset +
                    2 * disc * half_disc_offset * half_centroid;
  const parts::PlateMass mass = parts::MassOf(plate);
  const double per_area = 2700 * 4 * 1e-9;
  EXPECT_NEAR(mass.mass_kg, stadium * per_area, 1e-12);
  EXPECT_NEAR((mass.centre_mm - Vector2d(30, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR(mass.zz_kg_mm2, (xx + yy) * per_area, 1e-9);
  EXPECT_NEAR(mass.xx_kg_mm2, xx * per_area + mass.mass_kg * 16 / 12, 1e-9);
  EXPECT_NEAR(mass.xy_kg_mm2, 0, 1e-12);

  plate.holes = {{{0, 0}, 8}, {{60, 0}, 8}};
  EXPECT_NEAR(parts::MassOf(plate).area_mm2, stadium - 2 * std::numbers::pi * 16, 1e-10);
}

// A triangle with one hole against a sum over squares of 0.1 mm: the outline is 0.05 mm uncertain along 250 mm.
TEST(Plates, MassOfATriangleAgainstAGrid) {
  parts::Plate plate = BarOf(1, 8);
  plate.corners = {{0, 0}, {60, 20}, {10, 70}};
  plate.holes = {{{10, 60}, 9}};
  const auto inside = [&](const Vector2d& point) {
    if ((point - Vector2d(10, 60)).norm() < 4.5) return false;
    bool in = true;
    double nearest = HUGE_VAL;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector2d a = plate.corners[i], side = plate.corners[(i + 1) % 3] - a, to = point - a;
      in = in && side.x() * to.y() - side.y() * to.x() >= 0;
      nearest = std::min(nearest, (to - std::clamp(to.dot(side) / side.squaredNorm(), 0.0, 1.0) * side).norm());
    }
    return in || nearest < 8;
  };
  constexpr double kStep = 0.1;
  double area = 0, xx = 0, yy = 0, xy = 0;
  Vector2d first(0, 0);
  for (double x = -8 + kStep / 2; x < 68; x += kStep)
    for (double y = -8 + kStep / 2; y < 78; y += kStep) {
      if (!inside({x, y})) continue;
      constexpr double kArea = kStep * kStep;
      area += kArea;
      first += kArea * Vector2d(x, y);
      xx += kArea * y * y;
      yy += kArea * x * x;
      xy += kArea * x * y;
    }
  const parts::PlateMass mass = parts::MassOf(plate);
  const double per_area = 2700 * 4 * 1e-9;
  const Vector2d centre = first / area;
  constexpr double kRelative = 1e-3;
  EXPECT_NEAR(mass.area_mm2, area, kRelative * area);
  EXPECT_NEAR((mass.centre_mm - centre).norm(), 0, 0.02);
  const double zz = xx + yy - area * centre.squaredNorm(), product = xy - area * centre.x() * centre.y();
  EXPECT_NEAR(mass.zz_kg_mm2, zz * per_area, kRelative * zz * per_area);
  EXPECT_NEAR(mass.xy_kg_mm2, -product * per_area, kRelative * zz * per_area);
}

}  // namespace
}  // namespace lake
