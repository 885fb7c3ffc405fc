// A flat part: the hull of a few corners, moved out by a radius, with holes. Lengths in mm, in a frame of its own.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace lake::parts {

struct Hole {
  Eigen::Vector2d at_mm;
  double diameter_mm = 0;
};

struct Plate {
  std::string name;                      // "shank link"
  std::string label;                     // engraved: "KS"
  std::vector<Eigen::Vector2d> corners;  // of a convex polygon, anticlockwise, two or more
  double radius_mm = 0;
  double thickness_mm = 0;
  double density_kg_m3 = 0;
  std::vector<Hole> holes;
};

// A piece of an outline: a line, or an arc anticlockwise about its centre.
struct OutlinePiece {
  Eigen::Vector2d from, to;
  bool is_arc = false;
  Eigen::Vector2d centre{0, 0};
  double from_rad = 0, to_rad = 0;  // of an arc, to_rad > from_rad
};

// Anticlockwise and closed: a line along each side, an arc about each corner.
std::vector<OutlinePiece> OutlineOf(const Plate& plate);

// By Green's theorem over outline and holes.
struct PlateMass {
  double area_mm2 = 0;
  double mass_kg = 0;
  Eigen::Vector2d centre_mm{0, 0};
  // About the centre of mass, in the plate's axes and z through its thickness; xz and yz vanish.
  double xx_kg_mm2 = 0, yy_kg_mm2 = 0, zz_kg_mm2 = 0, xy_kg_mm2 = 0;
};
PlateMass MassOf(const Plate& plate);

}  // namespace lake::parts
