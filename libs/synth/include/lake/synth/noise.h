// From light to 8 bits: the noise and quantisation of a recording.
#pragma once

#include <cstdint>
#include <mutex>
#include <opencv2/core/mat.hpp>

namespace lake::synth {

// Variance of a pixel = read_sd² + gain × level (levels in grey values 0..255, before clipping): read noise and shot
// noise.
struct SensorNoise {
  double read_sd = 1.0;
  double gain = 0.012;
};

// Of the recorded value, rounding to whole grey values included (1/12).
double NoiseVariance(const SensorNoise& noise, double level);

// Adds noise, rounds, clips to 0..255. The noise is cut from one seeded tile of 2048 × 2048 normal numbers at a place
// and with a sign that are drawn for every frame and channel, so it never stands still; two frames share a pixel's
// value with a chance of 2^-22.
class Sensor {
 public:
  Sensor(const SensorNoise& noise, std::uint64_t seed);

  // `image`: CV_32FC1 or CV_32FC3 grey values; returns CV_8U of as many channels.
  cv::Mat Record(const cv::Mat& image, int frame) const;

 private:
  SensorNoise noise_;
  std::uint64_t seed_;
  mutable std::once_flag tile_made_;
  mutable cv::Mat tile_;  // made when the first picture is recorded
};

}  // namespace lake::synth
