#include "lake/video/halve.h"

#include <cassert>
#include <cstdint>
#include <cstring>

#include "lake/core/wide_vectors.h"

namespace lake::video {
namespace {

// Whichever comes first in memory: a vector is loaded once and not taken apart.
inline std::uint16_t SumOfPair(const std::uint8_t* left) {
  std::uint16_t pair;
  std::memcpy(&pair, left, sizeof pair);
  return static_cast<std::uint16_t>((pair & 0xFF) + (pair >> 8));
}

LAKE_WIDE_VECTORS void HalveRows(const std::uint8_t* above, const std::uint8_t* below, int width, std::uint8_t* half) {
  for (int x = 0; x < width; ++x) {
    const auto sum = static_cast<std::uint16_t>(SumOfPair(above + 2 * x) + SumOfPair(below + 2 * x) + 2);
    half[x] = static_cast<std::uint8_t>(sum >> 2);
  }
}

// (sum of four) · factor / 2^16 + offset, in 1/256 of a level: all in 16 bits, so that a vector holds most.
LAKE_WIDE_VECTORS void HalveRowsInto(const std::uint8_t* above, const std::uint8_t* below, int width,
                                     std::uint16_t factor, std::uint16_t offset, std::uint8_t* half) {
  for (int x = 0; x < width; ++x) {
    const auto sum = static_cast<std::uint16_t>(SumOfPair(above + 2 * x) + SumOfPair(below + 2 * x));
    const auto in_256ths = static_cast<std::uint16_t>(sum << 6);
    const auto scaled = static_cast<std::uint16_t>((std::uint32_t{in_256ths} * factor) >> 16);
    half[x] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(scaled + offset) >> 8);
  }
}

void CreateHalf(const cv::Mat& picture, cv::Mat& half) {
  assert(picture.type() == CV_8UC1);
  half.create(picture.rows / 2, picture.cols / 2, CV_8UC1);
}

}  // namespace

void Halve(const cv::Mat& picture, cv::Mat& half) {
  CreateHalf(picture, half);
  for (int y = 0; y < half.rows; ++y) HalveRows(picture.ptr(2 * y), picture.ptr(2 * y + 1), half.cols, half.ptr(y));
}

void HalveToLimitedRange(const cv::Mat& picture, Sample sample, cv::Mat& half) {
  constexpr double kLumaSteps = 219, kChromaSteps = 224, kFullSteps = 255;
  const double share = (sample == Sample::kLuma ? kLumaSteps : kChromaSteps) / kFullSteps;
  const double lowest = sample == Sample::kLuma ? 16 : 128 * (1 - share);
  constexpr double kRounding = 0.5;
  const auto factor = static_cast<std::uint16_t>(share * (1 << 16) + kRounding);
  const auto offset = static_cast<std::uint16_t>((lowest + kRounding) * 256 + kRounding);
  CreateHalf(picture, half);
  for (int y = 0; y < half.rows; ++y)
    HalveRowsInto(picture.ptr(2 * y), picture.ptr(2 * y + 1), half.cols, factor, offset, half.ptr(y));
}

}  // namespace lake::video
