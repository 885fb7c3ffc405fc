// Exact area coverage of pixels by polygons: the one drawing primitive of the renderer.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

namespace lake::synth {

using Polygon = std::vector<Eigen::Vector2d>;

// Sums weight × (the part of each cell that lies inside a polygon). Every edge adds, cell by cell, the signed area
// between itself and the right border; one running sum per row then gives the coverage, exact up to rounding. Polygons
// must not cross themselves; their orientation does not matter; what lies outside the raster is cut off exactly.
class PolygonRaster {
 public:
  // Cell (0, 0) covers x, y in 0..1 of the polygons' coordinates.
  PolygonRaster(int width, int height);

  void Add(std::span<const Eigen::Vector2d> polygon, double weight = 1);

  // CV_32FC1 of the raster's size.
  cv::Mat Coverage() const;

 private:
  void AddEdge(Eigen::Vector2d from, Eigen::Vector2d to, double weight);
  void AddInRow(int row, double x0, double x1, double signed_height);

  int width_, height_;
  std::vector<double> change_;  // per row width + 1 cells: the difference of the coverage to the cell on the left
};

double SignedArea(std::span<const Eigen::Vector2d> polygon);

}  // namespace lake::synth
