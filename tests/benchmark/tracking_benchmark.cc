// What tracking does to each frame: fits of blobs (a lone one by radius, touching ones together), and the search of a
// whole picture of 1080p.
#include <benchmark/benchmark.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <span>
#include <vector>

#include "lake/tracking/blob_fit.h"
#include "lake/tracking/blob_search.h"

namespace {

using namespace lake;

// Discs of 220 on 50 with an edge of 0.8 px and noise of 2 grey levels.
cv::Mat Picture(const cv::Size& size, const std::vector<tracking::Blob>& blobs) {
  cv::Mat grey(size, CV_32F, cv::Scalar(50)), noise(size, CV_32F);
  for (const tracking::Blob& blob : blobs) {
    constexpr int kShift = 10;
    const auto fixed = [](double px) { return static_cast<int>(std::lround(px * (1 << kShift))); };
    cv::circle(grey, {fixed(blob.center.x()), fixed(blob.center.y())}, fixed(blob.RadiusPx()), cv::Scalar(220),
               cv::FILLED, cv::LINE_8, kShift);
  }
  cv::GaussianBlur(grey, grey, {}, 0.8);
  cv::RNG(1).fill(noise, cv::RNG::NORMAL, 0, 2);
  cv::Mat picture;
  cv::Mat(grey + noise).convertTo(picture, CV_8U);
  return picture;
}

// Starts as the tracker has them: predicted to a tenth of a pixel.
void FitOne(benchmark::State& state) {
  const tracking::Blob blob = tracking::DiscBlob({40.3, 39.6}, static_cast<double>(state.range(0)));
  const cv::Mat picture = Picture({80, 80}, {blob});
  tracking::Blob start = blob;
  start.center += Eigen::Vector2d(0.1, -0.05);
  for (auto _ : state) benchmark::DoNotOptimize(tracking::FitBlobs(picture, std::span(&start, 1), {}));
}
BENCHMARK(FitOne)->Arg(2)->Arg(4)->Arg(8)->Arg(20);

void FitStreaked(benchmark::State& state) {
  const tracking::Blob blob = tracking::DiscBlob({40.3, 39.6}, 4);
  const cv::Mat picture = Picture({80, 80}, {blob});
  tracking::Blob start = blob;
  start.blur_px = {static_cast<double>(state.range(0)), 0};
  for (auto _ : state) benchmark::DoNotOptimize(tracking::FitBlobs(picture, std::span(&start, 1), {}));
}
BENCHMARK(FitStreaked)->Arg(3)->Arg(6);

void FitTouching(benchmark::State& state) {
  std::vector<tracking::Blob> blobs;
  for (int i = 0; i < state.range(0); ++i)
    blobs.push_back(tracking::DiscBlob({30.3 + 10 * (i % 2), 30.2 + 10 * (i / 2)}, 4));
  const cv::Mat picture = Picture({80, 80}, blobs);
  for (auto _ : state) benchmark::DoNotOptimize(tracking::FitBlobs(picture, blobs, {}));
}
BENCHMARK(FitTouching)->Arg(2)->Arg(4);

void SearchPicture(benchmark::State& state) {
  std::vector<tracking::Blob> blobs;
  for (int i = 0; i < 8; ++i) blobs.push_back(tracking::DiscBlob({200.0 + 200 * i, 300 + 60.0 * i}, 4));
  const cv::Mat picture = Picture({1920, 1080}, blobs);
  const cv::Rect all(0, 0, picture.cols, picture.rows);
  tracking::BlobSearchOptions options;
  if (state.range(0)) options.min_radius_px = 2.2, options.max_radius_px = 7.2;  // once markers are followed
  for (auto _ : state) benchmark::DoNotOptimize(tracking::FindBlobs(picture, all, options));
}
BENCHMARK(SearchPicture)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
