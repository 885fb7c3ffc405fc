// Positions of markers in a picture of 1080p, ours against what OpenCV has: the time of a whole picture, and as
// counters the share of the markers that is found (within a pixel), the root mean square error per axis and the false
// finds. Discs at random places, an edge of 0.8 px, noise of 2 grey levels on a background that slopes.
#include <benchmark/benchmark.h>

#include <cmath>
#include <functional>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <span>
#include <vector>

#include "lake/tracking/blob_fit.h"
#include "lake/tracking/blob_search.h"

namespace {

using namespace lake;
using Places = std::vector<Eigen::Vector2d>;

struct Scene {
  cv::Mat picture;
  Places truth;
};

// The share of a pixel that a disc covers, from 16 x 16 places in it.
double Coverage(const Eigen::Vector2d& centre, double radius_px, int x, int y) {
  constexpr int kSteps = 16;
  int inside = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j)
      inside +=
          std::hypot(x - 0.5 + (i + 0.5) / kSteps - centre.x(), y - 0.5 + (j + 0.5) / kSteps - centre.y()) <= radius_px;
  return static_cast<double>(inside) / (kSteps * kSteps);
}

// Eight discs of grey level 220.
Scene MakeScene(double radius_px, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> offset(-0.5, 0.5);
  Scene scene;
  cv::Mat grey(1080, 1920, CV_32F), noise(grey.size(), CV_32F);
  for (int x = 0; x < grey.cols; ++x) grey.col(x) = 40 + 0.01F * static_cast<float>(x);
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector2d place{200 + 200 * i + offset(random), 300 + 60 * i + offset(random)};
    scene.truth.push_back(place);
    const int reach = static_cast<int>(radius_px) + 2, middle_x = 200 + 200 * i, middle_y = 300 + 60 * i;
    for (int y = middle_y - reach; y <= middle_y + reach; ++y)
      for (int x = middle_x - reach; x <= middle_x + reach; ++x) {
        float& level = grey.at<float>(y, x);
        level += static_cast<float>(Coverage(place, radius_px, x, y)) * (220 - level);
      }
  }
  cv::GaussianBlur(grey, grey, {}, 0.8);
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0, 2);
  cv::Mat(grey + noise).convertTo(scene.picture, CV_8U);
  return scene;
}

Places Ours(const cv::Mat& picture) {
  Places places;
  const cv::Rect all(0, 0, picture.cols, picture.rows);
  for (const tracking::BlobCandidate& found : tracking::FindBlobs(picture, all, {})) {
    const tracking::Blob start = tracking::DiscBlob(found.position, found.radius_px);
    if (const auto fits = tracking::FitBlobs(picture, std::span(&start, 1), {}))
      places.push_back(fits->front().blob.center);
  }
  return places;
}

Places SimpleBlobDetector(const cv::Mat& picture) {
  cv::SimpleBlobDetector::Params parameters;
  parameters.filterByColor = true;
  parameters.blobColor = 255;
  parameters.minArea = 5;
  parameters.maxArea = 5000;
  std::vector<cv::KeyPoint> found;
  cv::SimpleBlobDetector::create(parameters)->detect(picture, found);
  Places places;
  for (const cv::KeyPoint& point : found) places.emplace_back(point.pt.x, point.pt.y);
  return places;
}

cv::Mat Thresholded(const cv::Mat& picture) {
  constexpr double kMiddle = 130;  // between marker and background
  cv::Mat bright;
  cv::threshold(picture, bright, kMiddle, 255, cv::THRESH_BINARY);
  return bright;
}

// A threshold, and the centroid of each connected component.
Places Components(const cv::Mat& picture) {
  cv::Mat labels, statistics, centroids;
  const int count = cv::connectedComponentsWithStats(Thresholded(picture), labels, statistics, centroids);
  Places places;
  for (int i = 1; i < count; ++i) places.emplace_back(centroids.at<double>(i, 0), centroids.at<double>(i, 1));
  return places;
}

// The same, weighted by what is brighter than the threshold.
Places WeightedComponents(const cv::Mat& picture) {
  cv::Mat labels, statistics, centroids;
  const int count = cv::connectedComponentsWithStats(Thresholded(picture), labels, statistics, centroids);
  Places places;
  for (int i = 1; i < count; ++i) {
    const cv::Rect box(statistics.at<int>(i, cv::CC_STAT_LEFT) - 2, statistics.at<int>(i, cv::CC_STAT_TOP) - 2,
                       statistics.at<int>(i, cv::CC_STAT_WIDTH) + 4, statistics.at<int>(i, cv::CC_STAT_HEIGHT) + 4);
    const cv::Rect inside = box & cv::Rect(0, 0, picture.cols, picture.rows);
    double darkest = 0;
    cv::minMaxLoc(picture(inside), &darkest);
    cv::Mat weights;
    picture(inside).convertTo(weights, CV_32F, 1, -darkest);
    const cv::Moments moments = cv::moments(weights);
    places.emplace_back(inside.x + moments.m10 / moments.m00, inside.y + moments.m01 / moments.m00);
  }
  return places;
}

void Detect(benchmark::State& state, Places (*detect)(const cv::Mat&)) {
  constexpr int kScenes = 8;
  std::vector<Scene> scenes;
  for (unsigned seed = 1; seed <= kScenes; ++seed)
    scenes.push_back(MakeScene(static_cast<double>(state.range(0)), seed));
  double square = 0;
  int found = 0, wrong = 0, all = 0;
  std::size_t next = 0;
  for (auto _ : state) benchmark::DoNotOptimize(detect(scenes[next++ % kScenes].picture));
  for (const Scene& scene : scenes) {
    const Places places = detect(scene.picture);
    all += static_cast<int>(scene.truth.size());
    for (const Eigen::Vector2d& place : places) {
      double nearest = INFINITY;
      for (const Eigen::Vector2d& truth : scene.truth) nearest = std::min(nearest, (place - truth).norm());
      nearest <= 1 ? (++found, square += nearest * nearest / 2) : ++wrong;
    }
  }
  state.counters["found"] = static_cast<double>(found) / all;
  state.counters["rms_px"] = std::sqrt(square / found);
  state.counters["false"] = wrong;
}

void Radii(benchmark::internal::Benchmark* benchmark) {
  for (const int radius_px : {2, 4, 8}) benchmark->Arg(radius_px);
  benchmark->Unit(benchmark::kMillisecond);
}
BENCHMARK_CAPTURE(Detect, lake, Ours)->Apply(Radii);
BENCHMARK_CAPTURE(Detect, SimpleBlobDetector, SimpleBlobDetector)->Apply(Radii);
BENCHMARK_CAPTURE(Detect, components, Components)->Apply(Radii);
BENCHMARK_CAPTURE(Detect, weighted_components, WeightedComponents)->Apply(Radii);

}  // namespace

BENCHMARK_MAIN();
