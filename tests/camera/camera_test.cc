#include "lake/camera/camera.h"

#include <ceres/jet.h>
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "lake/core/error.h"
#include "message_of.h"

namespace lake {
namespace {

camera::Camera Pinhole() {
  return {1280, 720, 1100, 1090, 640, 352, {}};
}

camera::Camera WithDistortion(const std::array<double, 5>& distortion) {
  camera::Camera camera = Pinhole();
  camera.distortion = distortion;
  return camera;
}

// A plane 3 m away, turned about all three axes.
camera::PlanePose SomePlane() {
  camera::PlanePose pose = camera::PlanePose::Identity();
  pose.linear() = (Eigen::AngleAxisd(std::numbers::pi + 0.15, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  pose.translation() = Eigen::Vector3d(-300, 500, 3000);
  return pose;
}

const std::array<double, 5> kMildBarrel = {-0.28, 0.09, 6e-4, -4e-4, -0.012};

// Lenses from phone to action camera, and OpenCV's published ones.
const std::vector<std::array<double, 5>> kLenses = {{0, 0, 0, 0, 0},
                                                    kMildBarrel,
                                                    {0.12, -1.085, 1.2e-4, -4.6e-4, 2.954},
                                                    {-0.266, -0.0386, 1.78e-3, -2.8e-4, 0.238},
                                                    {0.3, 0, 5e-3, -5e-3, 0},
                                                    {-0.4, 0.2, 0, 0, -0.05}};

TEST(Camera, RayIsTheInverseOfProjectionOverThePicture) {
  for (const auto& lens : kLenses) {
    const camera::Camera camera = WithDistortion(lens);
    int seen = 0;
    for (int y = 0; y < camera.image_height; y += 37) {
      for (int x = 0; x < camera.image_width; x += 41) {
        const Eigen::Vector2d pixel(x, y);
        try {
          const Eigen::Vector3d ray = camera::RayFromPixel(camera, pixel);
          EXPECT_LT((camera::Project(camera, ray) - pixel).norm(),
                    1e-8);  // 1e-13 of a normalised coordinate times fx, some rounding
          EXPECT_LE(ray.head<2>().norm(), camera::FoldRadius(camera));
          ++seen;
        } catch (const Error&) {
        }
      }
    }
    EXPECT_GT(seen, 500) << "k1 = " << lens[0];  // of 640: the corners of a strong lens may be beyond its fold
  }
}

TEST(Camera, RaysInsideTheFoldComeBackWhateverTheLens) {
  for (const auto& lens : kLenses) {
    const camera::Camera camera = WithDistortion(lens);
    const double limit =
        std::min(0.97 * camera::FoldRadius(camera), 1.5);  // tangential terms move the fold by some 1e-2
    for (double angle = 0; angle < 6.2; angle += 0.31) {
      for (double r = 0; r < limit; r += limit / 40) {
        const Eigen::Vector3d ray(r * std::cos(angle), r * std::sin(angle), 1);
        const Eigen::Vector3d found = camera::RayFromPixel(camera, camera::Project(camera, ray));
        // Near the fold the inverse loses digits: 1e-14 over a slope of some 1e-2, and the rounding of pixels of 1e3.
        EXPECT_LT((found - ray).norm(), 1e-9) << "r " << r << " k1 " << lens[0];
      }
    }
  }
}

// The fold of r (1 + k1 r²) is at r² = −1/(3 k1), its largest value 2/3 of that radius.
TEST(Camera, PixelsBeyondTheFoldAreAnError) {
  const camera::Camera camera = WithDistortion({-0.3, 0, 0, 0, 0});
  const double fold = 1 / std::sqrt(0.9);
  EXPECT_NEAR(camera::FoldRadius(camera), fold, 1e-12);
  const double edge_px = 2.0 / 3 * fold * camera.fx;
  EXPECT_NO_THROW(camera::RayFromPixel(camera, {camera.cx + edge_px * (1 - 1e-6), camera.cy}));
  EXPECT_THROW(camera::RayFromPixel(camera, {camera.cx + edge_px * (1 + 1e-6), camera.cy}), Error);
  EXPECT_EQ(camera::FoldRadius(WithDistortion({0.1, 0, 0, 0, 0})), std::numeric_limits<double>::infinity());
}

// A polynomial that folds and then rises again has a third branch, with a positive Jacobian, onto which Newton's method
// started at the pixel runs. Those rays are not what the camera saw.
TEST(Camera, RaysOnTheSecondRisingBranchAreNotTaken) {
  const camera::Camera camera = WithDistortion({-0.5, 0.09, 0, 0, 0});
  const double fold = camera::FoldRadius(camera);
  ASSERT_TRUE(std::isfinite(fold));
  const double edge = fold * (1 - 0.5 * fold * fold + 0.09 * std::pow(fold, 4));
  for (const double beyond : {1.001, 1.2, 2.0, 5.0})
    EXPECT_THROW(camera::RayFromPixel(camera, {camera.cx, camera.cy + camera.fy * edge * beyond}), Error) << beyond;
  const Eigen::Vector3d inside = camera::RayFromPixel(camera, {camera.cx, camera.cy + camera.fy * edge * 0.999});
  EXPECT_LT(inside.y(), fold);
}

TEST(Camera, NonsensePixelsAndPointsAreErrors) {
  const camera::Camera camera = WithDistortion(kMildBarrel);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e300})
    EXPECT_THROW(camera::RayFromPixel(camera, {bad, 10}), Error) << bad;
  EXPECT_THROW(camera::Project(camera, {1, 1, -5}), Error);
  EXPECT_THROW(camera::Project(camera, {1, 1, std::nan("")}), Error);
}

TEST(Camera, PlaneAndPixelAreInverse) {
  const camera::Camera camera = WithDistortion(kMildBarrel);
  for (const double depth : {-80.0, 0.0, 40.0})
    for (const Eigen::Vector2d& point : {Eigen::Vector2d(0, 0), Eigen::Vector2d(600, 300), Eigen::Vector2d(-200, 900)})
      EXPECT_LT((camera::PlaneFromPixel(camera, SomePlane(), camera::PixelFromPlane(camera, SomePlane(), point, depth),
                                        depth) -
                 point)
                    .norm(),
                1e-9);
}

TEST(Camera, PlaneDerivativesAreThoseOfDifferences) {
  const camera::Camera camera = WithDistortion(kMildBarrel);
  const Eigen::Vector2d pixel(1010, 130);
  const double depth = 25, step = 1e-3;
  const camera::PlanePoint point = camera::PlanePointFromPixel(camera, SomePlane(), pixel, depth);
  const auto at = [&](double dx, double dy, double dd) {
    return camera::PlaneFromPixel(camera, SomePlane(), pixel + Eigen::Vector2d(dx, dy), depth + dd);
  };
  Eigen::Matrix2d differences;
  differences.col(0) = (at(step, 0, 0) - at(-step, 0, 0)) / (2 * step);
  differences.col(1) = (at(0, step, 0) - at(0, -step, 0)) / (2 * step);
  const Eigen::Vector2d parallax = (at(0, 0, 1) - at(0, 0, -1)) / 2;
  // Rounding 1e-12 mm / step 1e-3 px; the third derivative is of the order 1e-6 / px².
  EXPECT_LT((point.mm_per_px - differences).norm(), 1e-8);
  EXPECT_LT((point.mm_per_depth_mm - parallax).norm(), 1e-10);
}

TEST(Camera, SigmaInThePlaneIsThatOfSamples) {
  const camera::Camera camera = WithDistortion(kMildBarrel);
  const Eigen::Vector2d pixel(1010, 130);
  const camera::PlanePoint point = camera::PlanePointFromPixel(camera, SomePlane(), pixel);
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0, 0.3);
  constexpr int kSamples = 20000;
  double sum = 0;
  for (int i = 0; i < kSamples; ++i)
    sum += (camera::PlaneFromPixel(camera, SomePlane(), pixel + Eigen::Vector2d{noise(random), noise(random)}) -
            point.position_mm)
               .squaredNorm();
  // 2 × 20000 values: relative sd 0.35 %; four of them.
  EXPECT_NEAR(camera::SigmaInPlane(point, 0.3) / std::sqrt(sum / (2 * kSamples)), 1, 0.015);
}

// The claim: a marker 40 mm in front of the plane, found at 0.1 px, comes out within 0.3 mm when its depth is
// given.
TEST(Camera, DepthUndoesTheParallaxOfAMarkerThatStandsProud) {
  const camera::Camera camera = WithDistortion(kMildBarrel);
  const Eigen::Vector2d truth(700, 500);
  const Eigen::Vector2d pixel = camera::PixelFromPlane(camera, SomePlane(), truth, 40) + Eigen::Vector2d(0.07, -0.07);
  EXPECT_LT((camera::PlaneFromPixel(camera, SomePlane(), pixel, 40) - truth).norm(), 0.3);
  const camera::PlanePoint without = camera::PlanePointFromPixel(camera, SomePlane(), pixel);
  const double error = (without.position_mm - truth).norm();
  EXPECT_GT(error, 5);
  EXPECT_NEAR(40 * without.mm_per_depth_mm.norm(), error,
              0.3);  // what the summary says of it; exact but for the pixel's error
}

TEST(Camera, ARayThatMissesThePlaneIsAnError) {
  camera::PlanePose edge_on = SomePlane();
  edge_on.linear() = Eigen::AngleAxisd(std::numbers::pi / 2 + 0.3, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const camera::Camera camera = Pinhole();
  int missed = 0;
  for (int y = 0; y < camera.image_height; y += 10) {
    try {
      camera::PlaneFromPixel(camera, edge_on, {640, static_cast<double>(y)});
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("does not meet the sagittal plane"));
      ++missed;
    }
  }
  EXPECT_GT(missed, 0);
}

TEST(Camera, JetsAndDoublesProjectAlike) {
  using Jet = ceres::Jet<double, 3>;
  const camera::Camera camera = WithDistortion(kMildBarrel);
  const Jet intrinsics[] = {Jet(camera.fx), Jet(camera.fy), Jet(camera.cx), Jet(camera.cy)};
  Jet distortion[5];
  for (int i = 0; i < 5; ++i) distortion[i] = Jet(camera.distortion[static_cast<std::size_t>(i)]);
  const Eigen::Vector3d p(0.3, -0.2, 1.7);
  const auto pixel = camera::ProjectLens<Jet>(camera::LensModel::kBrownConrady, 5, intrinsics, distortion,
                                              {Jet(p.x(), 0), Jet(p.y(), 1), Jet(p.z(), 2)});
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
    const Eigen::Vector2d slope = (camera::Project(camera, p + step) - camera::Project(camera, p - step)) / (2 * kStep);
    EXPECT_NEAR(pixel.x().v[i], slope.x(), 1e-5);  // rounding 1e-13 * 1e3 / 1e-5
    EXPECT_NEAR(pixel.y().v[i], slope.y(), 1e-5);
  }
}

TEST(CheckResolution, NamesFilesSizesAndTheWayOut) {
  const camera::Camera camera = Pinhole();
  EXPECT_NO_THROW(camera::CheckResolution(camera, "camera.yaml", 1280, 720, "human.mp4"));
  const auto message = [&](int width, int height) {
    return MessageOf([&] { camera::CheckResolution(camera, "camera.yaml", width, height, "human.mp4"); });
  };
  EXPECT_EQ(message(1920, 1080),
            "camera.yaml: the camera was calibrated at 1280x720 px, but human.mp4 has 1920x1080; calibrate in the same "
            "video mode");
  EXPECT_THAT(message(720, 1280), testing::HasSubstr("turned the same way"));
}

}  // namespace
}  // namespace lake
