#include "lake/synth/noise.h"

#include <algorithm>
#include <cmath>
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

// One run of pixels of one channel; plain so that the compiler makes vector code of it.
void RecordRun(const float* light, const float* normal, std::uint8_t* out, int count, int stride, float read_variance,
               float gain, float sign) {
  for (int i = 0; i < count; ++i) {
    const float level = light[i * stride];
    const float sd = std::sqrt(read_variance + gain * std::max(level, 0.0f));
    const float value = level + sign * sd * normal[i];
    out[i * stride] = static_cast<std::uint8_t>(std::min(std::max(value, 0.0f), 255.0f) + 0.5f);
  }
}

}  // namespace

double NoiseVariance(const SensorNoise& noise, double level) {
  return noise.read_sd * noise.read_sd + noise.gain * std::max(level, 0.0) + 1.0 / 12;
}

Sensor::Sensor(const SensorNoise& noise, std::uint64_t seed) : noise_(noise), seed_(seed) {}

cv::Mat Sensor::Record(const cv::Mat& image, int frame) const {
  std::call_once(tile_made_, [this] { tile_ = NormalTile(seed_); });
  const int channels = image.channels();
  cv::Mat out(image.rows, image.cols, CV_8UC(channels));
  Random random(seed_, "noise place", static_cast<std::uint64_t>(frame));
  const float read_variance = static_cast<float>(noise_.read_sd * noise_.read_sd),
              gain = static_cast<float>(noise_.gain);
  for (int channel = 0; channel < channels; ++channel) {
    const int left = random.Integer(0, kNoiseTile - 1), top = random.Integer(0, kNoiseTile - 1);
    const float sign = random.Uniform() < 0.5 ? -1.0f : 1.0f;
    for (int row = 0; row < image.rows; ++row) {
      const float* const normal = tile_.ptr<float>((top + row) % kNoiseTile);
      for (int column = 0; column < image.cols;) {
        const int place = (left + column) % kNoiseTile, count = std::min(image.cols - column, kNoiseTile - place);
        RecordRun(image.ptr<float>(row) + column * channels + channel, normal + place,
                  out.ptr<std::uint8_t>(row) + column * channels + channel, count, channels, read_variance, gain, sign);
        column += count;
      }
    }
  }
  return out;
}

}  // namespace lake::synth
