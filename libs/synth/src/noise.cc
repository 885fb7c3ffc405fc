#include "lake/synth/noise.h"

#include <Eigen/Core>
#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "random.h"

namespace lake::synth {
namespace {

constexpr int kNoiseTile = 2048;

cv::Mat NormalTile(std::uint64_t seed) {
  Random random(seed, "noise tile");
  cv::Mat tile(kNoiseTile, kNoiseTile, CV_32FC1);
  for (int row = 0; row < kNoiseTile; ++row)
    for (int column = 0; column < kNoiseTile; ++column)
      tile.at<float>(row, column) = static_cast<float>(random.Normal());
  return tile;
}

// One run of pixels; in Eigen's arrays, as GCC makes no vector code of a loop with a square root that may set errno.
void RecordRun(const float* light, const float* normal, std::uint8_t* out, int count, float read_variance, float gain,
               float sign) {
  const Eigen::Map<const Eigen::ArrayXf> level(light, count), lot(normal, count);
  thread_local Eigen::ArrayXf value;
  value = (level + sign * (read_variance + gain * level.max(0.0f)).sqrt() * lot).max(0.0f).min(255.0f) + 0.5f;
  std::copy(value.begin(), value.end(), out);
}

}  // namespace

double NoiseVariance(const SensorNoise& noise, double level) {
  return noise.read_sd * noise.read_sd + noise.gain * std::max(level, 0.0) + 1.0 / 12;
}

Sensor::Sensor(const SensorNoise& noise, std::uint64_t seed) : noise_(noise), seed_(seed) {}

cv::Mat Sensor::Record(const cv::Mat& image, int frame) const {
  std::call_once(tile_made_, [this] { tile_ = NormalTile(seed_); });
  std::vector<cv::Mat> light = {image}, recorded;
  if (image.channels() > 1) cv::split(image, light);
  Random random(seed_, "noise place", static_cast<std::uint64_t>(frame));
  const float read_variance = static_cast<float>(noise_.read_sd * noise_.read_sd),
              gain = static_cast<float>(noise_.gain);
  for (const cv::Mat& channel : light) {
    cv::Mat& out = recorded.emplace_back(image.rows, image.cols, CV_8U);
    const int left = random.Integer(0, kNoiseTile - 1), top = random.Integer(0, kNoiseTile - 1);
    const float sign = random.Uniform() < 0.5 ? -1.0f : 1.0f;
    for (int row = 0; row < image.rows; ++row) {
      const float* const normal = tile_.ptr<float>((top + row) % kNoiseTile);
      for (int column = 0; column < image.cols;) {
        const int place = (left + column) % kNoiseTile, count = std::min(image.cols - column, kNoiseTile - place);
        RecordRun(channel.ptr<float>(row) + column, normal + place, out.ptr<std::uint8_t>(row) + column, count,
                  read_variance, gain, sign);
        column += count;
      }
    }
  }
  if (recorded.size() == 1) return recorded.front();
  cv::Mat merged;
  cv::merge(recorded, merged);
  return merged;
}

}  // namespace lake::synth
