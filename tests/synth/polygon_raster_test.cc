#include "lake/synth/polygon_raster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>

namespace lake {
namespace {

using Eigen::Vector2d;

synth::Polygon RandomTriangle(std::mt19937& engine, double low, double high) {
  std::uniform_real_distribution<double> place(low, high);
  return {{place(engine), place(engine)}, {place(engine), place(engine)}, {place(engine), place(engine)}};
}

TEST(PolygonRaster, CoversTheSharesOfCellsThatARectangleCovers) {
  synth::PolygonRaster raster(4, 3);
  const synth::Polygon box = {{0.25, 0.5}, {2.5, 0.5}, {2.5, 1.75}, {0.25, 1.75}};
  raster.Add(box);
  const cv::Mat expected = (cv::Mat_<float>(3, 4) << 0.375, 0.5, 0.25, 0, 0.5625, 0.75, 0.375, 0, 0, 0, 0, 0);
  EXPECT_LT(cv::norm(raster.Coverage(), expected, cv::NORM_INF), 1e-7);
}

TEST(PolygonRaster, OrientationDoesNotMatterAndWeightsAdd) {
  synth::Polygon box = {{0.25, 0.5}, {2.5, 0.5}, {2.5, 1.75}, {0.25, 1.75}};
  synth::PolygonRaster once(4, 3), turned(4, 3), parts(4, 3);
  once.Add(box);
  parts.Add(box, 0.25);
  std::reverse(box.begin(), box.end());
  turned.Add(box);
  parts.Add(box, 0.75);
  EXPECT_LT(cv::norm(once.Coverage(), turned.Coverage(), cv::NORM_INF), 1e-7);
  EXPECT_LT(cv::norm(once.Coverage(), parts.Coverage(), cv::NORM_INF), 1e-7);
}

TEST(PolygonRaster, SumIsTheAreaOfAnyTriangle) {
  std::mt19937 engine(11);
  for (int i = 0; i < 200; ++i) {
    const synth::Polygon triangle = RandomTriangle(engine, 1, 39);
    synth::PolygonRaster raster(40, 40);
    raster.Add(triangle);
    // Coverage is rounded to float: 1600 cells of at most 6e-8 each.
    EXPECT_NEAR(cv::sum(raster.Coverage())[0], std::abs(synth::SignedArea(triangle)), 1e-4);
  }
}

TEST(PolygonRaster, CuttingOffAtTheBorderLeavesTheRestAsItWas) {
  std::mt19937 engine(12);
  for (int i = 0; i < 200; ++i) {
    synth::Polygon triangle = RandomTriangle(engine, -20, 60);
    synth::PolygonRaster small(30, 30), large(100, 100);
    small.Add(triangle);
    for (Vector2d& corner : triangle) corner += Vector2d(30, 30);
    large.Add(triangle);
    EXPECT_LT(cv::norm(small.Coverage(), large.Coverage()(cv::Rect(30, 30, 30, 30)), cv::NORM_INF), 1e-6);
  }
}

TEST(PolygonRaster, AgreesWithCountedPointsInACell) {
  const synth::Polygon triangle = {{0.1, 0.2}, {0.9, 0.35}, {0.3, 0.95}};
  synth::PolygonRaster raster(1, 1);
  raster.Add(triangle);
  constexpr int kPoints = 1000;
  int inside = 0;
  for (int i = 0; i < kPoints; ++i)
    for (int j = 0; j < kPoints; ++j) {
      const Vector2d p((i + 0.5) / kPoints, (j + 0.5) / kPoints);
      bool in = true;
      for (int k = 0; k < 3; ++k) {
        const Vector2d edge = triangle[(k + 1) % 3] - triangle[k], to = p - triangle[k];
        in = in && edge.x() * to.y() - edge.y() * to.x() > 0;
      }
      inside += in;
    }
  // Counting errs by about the outline's length in points.
  EXPECT_NEAR(raster.Coverage().at<float>(0, 0), inside / double(kPoints * kPoints), 3.0 / kPoints);
}

}  // namespace
}  // namespace lake
