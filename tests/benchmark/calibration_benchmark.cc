// A camera from the corners of a board, ours against cv::calibrateCamera: the time of a calibration, and as counters
// the root mean square errors over the seeds of the focal lengths and of the principal point, and how far the found
// lens is from the true one over the picture (CompareCameras: what no rotation of the camera explains). All have the
// same views and the same nine unknowns: fx fy cx cy k1 k2 p1 p2 k3.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/calib3d.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "camera/board_scene.h"
#include "lake/camera/calibration.h"
#include "lake/camera/calibration_quality.h"

namespace {

using namespace lake;
using Views = std::vector<camera::BoardView>;
constexpr int kSeeds = 24;

struct Case {
  int views;
  double noise_px;
  bool spoilt;  // one corner in eighteen is found elsewhere, up to 8 px away along each axis
  std::string Name() const { return fmt::format("{} views, {:g}{}", views, noise_px, spoilt ? ", spoilt" : ""); }
};

Views MakeViews(const Case& which, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> far(-8, 8);
  const camera::Camera truth = scene::Lens();
  Views views;
  for (int i = 0; i < which.views; ++i) {
    const Eigen::Isometry3d pose = scene::RandomPose(truth, kBoard, random);
    camera::BoardView& view = views.emplace_back(scene::NoisyView(truth, kBoard, pose, which.noise_px, random));
    for (auto c = static_cast<std::size_t>(i % 18); which.spoilt && c < view.pixel.size(); c += 18)
      view.pixel[c] += Eigen::Vector2d{far(random), far(random)};
  }
  return views;
}

camera::Camera Ours(const Views& views) {
  const camera::Camera truth = scene::Lens();
  return camera::CalibrateCamera(kBoard, views, truth.image_width, truth.image_height).camera;
}

// The sum of squares instead of the robust loss: OpenCV's own problem.
camera::Camera OursSquared(const Views& views) {
  const camera::Camera truth = scene::Lens();
  camera::CalibrationOptions options;
  options.robust = false;
  return camera::CalibrateCamera(kBoard, views, truth.image_width, truth.image_height, options).camera;
}

// With its defaults: five coefficients, 30 iterations. Ours give a covariance as well, this gives none.
camera::Camera OpenCv(const Views& views) {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  const std::vector<Eigen::Vector2d> corners = camera::BoardCorners(kBoard);
  for (const camera::BoardView& view : views) {
    points.emplace_back();
    pixels.emplace_back();
    for (const Eigen::Vector2d& p : corners) points.back().emplace_back(p.x(), p.y(), 0);
    for (const Eigen::Vector2d& p : view.pixel) pixels.back().emplace_back(p.x(), p.y());
  }
  camera::Camera found = scene::Lens();
  cv::Mat k, d;
  std::vector<cv::Mat> r, t;
  cv::calibrateCamera(points, pixels, {found.image_width, found.image_height}, k, d, r, t);
  found.fx = k.at<double>(0, 0), found.fy = k.at<double>(1, 1);
  found.cx = k.at<double>(0, 2), found.cy = k.at<double>(1, 2);
  std::copy_n(d.ptr<double>(), 5, found.distortion.begin());
  return found;
}

void Calibrate(benchmark::State& state, camera::Camera (*calibrate)(const Views&), const Case& which) {
  std::vector<Views> recordings;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) recordings.push_back(MakeViews(which, seed));
  std::vector<camera::Camera> found;
  for (auto _ : state) found.push_back(calibrate(recordings[found.size() % kSeeds]));
  const camera::Camera truth = scene::Lens();
  double focal = 0, centre = 0, lens = 0;
  for (const camera::Camera& own : found) {
    focal += (std::pow(own.fx - truth.fx, 2) + std::pow(own.fy - truth.fy, 2)) / 2;
    centre += (std::pow(own.cx - truth.cx, 2) + std::pow(own.cy - truth.cy, 2)) / 2;
    lens += std::pow(camera::CompareCameras(truth, own).rms_px, 2);
  }
  const auto count = static_cast<double>(found.size());
  state.counters["focal_px"] = std::sqrt(focal / count);
  state.counters["centre_px"] = std::sqrt(centre / count);
  state.counters["lens_px"] = std::sqrt(lens / count);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const std::pair<const char*, camera::Camera (*)(const Views&)> competitors[] = {
      {"lake", Ours}, {"lake_squared", OursSquared}, {"OpenCV", OpenCv}};
  for (const Case& which :
       {Case{20, 0.05, false}, {20, 0.1, false}, {20, 0.3, false}, {20, 0.1, true}, {60, 0.1, false}})
    for (const auto& [name, calibrate] : competitors)
      benchmark::RegisterBenchmark(fmt::format("Calibrate/{}/{}", name, which.Name()).c_str(), Calibrate, calibrate,
                                   which)
          ->Iterations(kSeeds)
          ->Unit(benchmark::kMillisecond);
  benchmark::RunSpecifiedBenchmarks();
}
