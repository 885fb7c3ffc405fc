// Discs, edges and lines, as the search proposes them and the fit takes them.
#include "lake/tracking/blob_search.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "lake/tracking/marker_detector.h"
#include "tracking/marker_scene.h"

namespace lake {
namespace {

using Eigen::Vector2d;

TEST(BlobSearch, FindsDiscsOfAllSizesAndNothingElse) {
  const cv::Size size(320, 240);
  const SceneNoise noise;
  std::mt19937 random(17);
  std::uniform_real_distribution<double> fraction(-0.5, 0.5);
  for (const double radius : {2.0, 3.0, 4.5, 6.0, 9.0, 13.0, 20.0, 30.0}) {
    SceneMarker marker;
    marker.center = Vector2d(170, 120) + Vector2d{fraction(random), fraction(random)};
    marker.radius_px = radius;
    const cv::Mat grey = AddNoise(DrawMarkers(size, {marker}, 0.7, 40), noise, random);
    const auto found = tracking::FindBlobs(grey, {{0, 0}, size}, {});
    ASSERT_EQ(found.size(), 1u) << "radius " << radius;
    EXPECT_LE((found[0].position - marker.center).norm(), std::max(1.5, 0.5 * radius)) << "radius " << radius;
    EXPECT_LE(std::abs(std::log(found[0].radius_px / radius)), std::log(1.6))
        << "radius " << radius << ": " << found[0].radius_px;
  }
}

// What the function gives of the distance from a line through the picture's middle at this angle.
template <typename Level>
cv::Mat AcrossALine(double angle_deg, Level level) {
  cv::Mat picture(240, 320, CV_64F);
  const double a = angle_deg * CV_PI / 180;
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      picture.at<double>(y, x) = level((x - 160) * std::sin(a) - (y - 120) * std::cos(a));
  return picture;
}

std::size_t BlobsIn(const cv::Mat& levels, std::mt19937& random) {
  return tracking::FindBlobs(AddNoise(levels, SceneNoise{}, random), {{0, 0}, levels.size()}, {}).size();
}

constexpr double kAngles[] = {0, 20, 45, 77, 90};  // deg

TEST(BlobSearch, EdgesAndFlatPicturesHoldNoBlob) {
  std::mt19937 random(18);
  for (const double angle_deg : kAngles)
    EXPECT_EQ(BlobsIn(AcrossALine(angle_deg, [](double u) { return 40 + 75 * (1 + std::erf(u)); }), random), 0u)
        << angle_deg;
  EXPECT_EQ(BlobsIn(cv::Mat(240, 320, CV_64F, cv::Scalar(90)), random), 0u);
}

// The search may propose a piece of a line; the fit must not take it for a marker. Two frames, as the first only
// teaches the noise.
TEST(ReflectiveDetector, LinesAreNoMarkers) {
  std::mt19937 random(20);
  for (const double width_px : {1.0, 3.0, 6.0})
    for (const double angle_deg : kAngles) {
      const cv::Mat line =
          AcrossALine(angle_deg, [&](double u) { return 40 + 150 * std::exp(-0.5 * u * u / (width_px * width_px)); });
      const auto detector = tracking::MakeReflectiveDetector(tracking::Polarity::kBright, {});
      for (int i = 0; i < 2; ++i) {
        video::VideoFrame frame;
        frame.luma = AddNoise(line, SceneNoise{}, random);
        EXPECT_THAT(detector->Detect(frame, {}, tracking::Look::kEverywhere), testing::IsEmpty())
            << width_px << " px, " << angle_deg << " deg";
      }
    }
}

TEST(BlobSearch, StaysInItsRegion) {
  std::mt19937 random(19);
  SceneMarker inside, outside;
  inside.center = {220, 130}, outside.center = {60, 60};
  const cv::Mat grey = AddNoise(DrawMarkers({320, 240}, {inside, outside}, 0.7, 40), SceneNoise{}, random);
  const auto found = tracking::FindBlobs(grey, {160, 80, 140, 120}, {});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LE((found[0].position - inside.center).norm(), 2);
}

}  // namespace
}  // namespace lake
