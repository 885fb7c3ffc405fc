#include "lake/camera/homography.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <vector>

#include "lake/core/error.h"
#include "message_of.h"
#include "places.h"

namespace lake {
namespace {

using Points = std::vector<camera::PlaneCorrespondence>;

// A tilted view: mm to px.
Eigen::Matrix3d SomeView() {
  Eigen::Matrix3d h;
  h << 0.6, 0.08, 300, 0.05, -0.7, 500, 1e-4, -5e-5, 1;
  return h;
}

Points Seen(const Eigen::Matrix3d& image_from_plane, const std::vector<Eigen::Vector2d>& plane) {
  Points points;
  for (const auto& p : plane) points.push_back({(image_from_plane * p.homogeneous()).hnormalized(), p});
  return points;
}

const std::vector<Eigen::Vector2d> kCorners = {{0, 0}, {0, 740}, {590, 0}, {590, 740}};

TEST(PlaneHomography, FourExactPointsGiveTheMapping) {
  const camera::HomographyFit fit = camera::PlaneHomography(Seen(SomeView(), kCorners));
  const Eigen::Vector2d point(137, 412);
  const Eigen::Vector2d pixel = (SomeView() * point.homogeneous()).hnormalized();
  EXPECT_LT((camera::ApplyHomography(fit, pixel) - point).norm(), 1e-9);  // rounding of coordinates of 1e3
  EXPECT_LT(fit.rms_px, 1e-10);
}

TEST(PlaneHomography, NoiseAveragesOutAndTheRmsIsThatOfTheNoise) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0, 0.2);
  std::vector<Eigen::Vector2d> plane;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x) plane.emplace_back(50 * x, 50 * y);
  Points points = Seen(SomeView(), plane);
  for (auto& p : points) p.pixel += Eigen::Vector2d{noise(random), noise(random)};
  const camera::HomographyFit fit = camera::PlaneHomography(points);
  // 2-D RMS of 288 residuals with 8 unknowns: 0.2 sqrt(2) sqrt(280/288) = 0.279, relative sd 1/sqrt(2*280) = 4 %: three
  // of them.
  EXPECT_NEAR(fit.rms_px, 0.279, 0.036);
  const Eigen::Vector2d middle(275, 275);
  // One point's noise is about 0.35 mm; the mean of 144 points brings the middle to about 0.05 mm; four of that.
  EXPECT_LT((camera::ApplyHomography(fit, (SomeView() * middle.homogeneous()).hnormalized()) - middle).norm(), 0.2);
}

TEST(PlaneHomography, RefinementIsBetterThanItsStartForUnequalWeights) {
  // A strong perspective makes the algebraic error of the linear solution weigh far points too much: the geometric RMS
  // must be a minimum.
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 0.5);
  Eigen::Matrix3d view;
  view << 0.6, 0.1, 300, 0.05, -0.7, 700, 1e-3, 8e-4, 1;
  std::vector<Eigen::Vector2d> plane;
  for (int i = 0; i < 40; ++i) plane.emplace_back(std::fmod(137.0 * i, 600), std::fmod(211.0 * i, 700));
  Points points = Seen(view, plane);
  for (auto& p : points) p.pixel += Eigen::Vector2d{noise(random), noise(random)};
  const camera::HomographyFit fit = camera::PlaneHomography(points);
  const Eigen::Matrix3d back = fit.plane_from_image.inverse() / fit.plane_from_image.inverse().norm();
  for (int i = 0; i < 9; ++i) {
    for (const double step : {-1e-5, 1e-5}) {
      Eigen::Matrix3d moved = back;
      moved(i / 3, i % 3) *= 1 + step;
      double sum = 0;
      for (const auto& p : points)
        sum += ((moved * p.point_in_plane.homogeneous()).hnormalized() - p.pixel).squaredNorm();
      EXPECT_GE(std::sqrt(sum / 40), fit.rms_px * (1 - 1e-12)) << "element " << i;
    }
  }
}

TEST(PlaneHomography, SaysWhatIsWrong) {
  const auto message = [](const Points& points) { return MessageOf([&] { camera::PlaneHomography(points); }); };
  Points points = Seen(SomeView(), kCorners);
  EXPECT_THAT(message({points.begin(), points.begin() + 3}), testing::HasSubstr("at least 4"));
  EXPECT_THAT(message(Seen(SomeView(), {{0, 0}, {100, 0}, {200, 0}, {0, 100}})), testing::HasSubstr("in one line"));
  EXPECT_THAT(message(Seen(SomeView(), {{5, 5}, {5, 5}, {5, 5}, {5, 5}})), testing::HasSubstr("coincide"));
  std::swap(points[0].pixel, points[1].pixel);  // a bow tie
  EXPECT_THAT(message(points), testing::HasSubstr("same order"));
  points[0].pixel.x() = std::nan("");
  EXPECT_THAT(message(points), testing::HasSubstr("not finite"));
}

TEST(PlaneHomography, TellsTheHorizon) {
  const camera::HomographyFit fit = camera::PlaneHomography(Seen(SomeView(), kCorners));
  const Eigen::RowVector3d horizon = fit.plane_from_image.row(2);
  const Eigen::Vector2d at_horizon = -horizon.z() * horizon.head<2>().transpose() / horizon.head<2>().squaredNorm();
  EXPECT_THROW(camera::ApplyHomography(fit, 1.001 * at_horizon), Error);
  EXPECT_NO_THROW(camera::ApplyHomography(fit, 0.999 * at_horizon));
}

// Numbers of a European table: tabs, decimal comma.
std::vector<std::vector<double>> ReadTable(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    for (char& c : line) c = c == ',' ? '.' : c;
    std::istringstream words(line);
    std::vector<double> row;
    for (double value; words >> value;) row.push_back(value);
    if (row.size() == 4) rows.push_back(row);
  }
  return rows;
}

// A real recording: knee and thigh marker on a person who stands up and sits down in the calibrated plane (0.59 m ×
// 0.74 m).
class SitToStandVideo : public testing::TestWithParam<std::string> {};

TEST_P(SitToStandVideo, MapsTheMarkersToALegOfHumanSize) {
  const auto folder = SharedData() / "sts_markers_imu/data/video" / GetParam();
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is absent";
  const auto corners = ReadTable(folder / "calib.txt"), knee = ReadTable(folder / "knee.txt"),
             thigh = ReadTable(folder / "thigh.txt");
  ASSERT_EQ(corners.size(), 4u);
  Points points;
  for (std::size_t i = 0; i < 4; ++i) points.push_back({{corners[i][2], corners[i][3]}, kCorners[i]});
  const camera::HomographyFit fit = camera::PlaneHomography(points);
  for (const auto& p : points) EXPECT_LT((camera::ApplyHomography(fit, p.pixel) - p.point_in_plane).norm(), 1e-6);

  std::map<double, Eigen::Vector2d> knee_of_frame;  // the trackers lost frames independently
  for (const auto& row : knee) knee_of_frame[row[0]] = {row[2], row[3]};
  std::vector<double> length_mm;
  for (const auto& row : thigh)
    if (const auto found = knee_of_frame.find(row[0]); found != knee_of_frame.end())
      length_mm.push_back(
          (camera::ApplyHomography(fit, {row[2], row[3]}) - camera::ApplyHomography(fit, found->second)).norm());
  ASSERT_GT(length_mm.size(), 2500u);
  std::sort(length_mm.begin(), length_mm.end());
  const double median = length_mm[length_mm.size() / 2];
  // Two markers on one thigh; skin and out-of-plane movement change their distance by a few per cent.
  EXPECT_GT(median, 100);
  EXPECT_LT(median, 500);
  EXPECT_LT(length_mm[length_mm.size() * 95 / 100] - length_mm[length_mm.size() * 5 / 100], 0.2 * median);
  RecordProperty("median_mm", std::to_string(median));
}

INSTANTIATE_TEST_SUITE_P(People, SitToStandVideo, testing::Values("participant1", "participant2"));

}  // namespace
}  // namespace lake
