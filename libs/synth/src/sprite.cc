#include "sprite.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace lake::synth {
namespace {

// A sampled Gaussian of odd length, sum 1, on the fine grid.
cv::Mat CellKernel(double psf_sigma_px) {
  const double sigma = psf_sigma_px * kCells;
  const int half = static_cast<int>(std::ceil(5 * sigma));
  cv::Mat kernel(1, 2 * half + 1, CV_64FC1);
  for (int i = -half; i <= half; ++i)
    kernel.at<double>(i + half) = sigma > 0 ? std::exp(-0.5 * i * i / (sigma * sigma)) : 1;
  return kernel / cv::sum(kernel)[0];
}

struct FineCoverage {
  cv::Mat area, dark;
};

FineCoverage Draw(const Sprite& sprite, std::size_t first, std::size_t last, const cv::Rect& region, double weight) {
  PolygonRaster area(region.width * kCells, region.height * kCells), dark = area;
  bool any_dark = false;
  for (std::size_t i = first; i <= last; ++i) {
    area.Add(ToCells(sprite.instants[i].outline, region, kCells), weight);
    for (const Polygon& polygon : sprite.instants[i].dark) {
      dark.Add(ToCells(polygon, region, kCells), weight);
      any_dark = true;
    }
  }
  return {area.Coverage(), any_dark ? dark.Coverage() : cv::Mat()};
}

// Coverage of whole pixels as its neighbourhood sees it on the fine grid.
cv::Mat Finer(const cv::Mat& pixels) {
  cv::Mat fine;
  cv::resize(pixels, fine, cv::Size(), kCells, kCells, cv::INTER_LINEAR);
  return fine;
}

void Accumulate(cv::Mat& sum, const cv::Mat& part) {
  if (part.empty()) return;
  sum = sum.empty() ? part.clone() : cv::Mat(sum + part);
}

float Level(const cv::Vec3f& bgr, int channels, int channel) {
  return channels == 1 ? Grey(bgr) : bgr[channel];
}

// Light × (1 − covered) of one channel on the fine grid.
cv::Mat Emitted(const Sprite& sprite, const SpriteCoverage& coverage, int channels, int channel) {
  const float light = Level(sprite.light_bgr, channels, channel), dark = Level(sprite.dark_bgr, channels, channel);
  cv::Mat emitted = light * coverage.area;
  if (!coverage.dark.empty()) emitted += (dark - light) * coverage.dark;
  return emitted;
}

cv::Mat ChannelUnder(const SpriteCoverage& coverage, const Canvas& under, int channel) {
  cv::Mat single;
  cv::extractChannel(under.image(coverage.region - under.corner), single, channel);
  return single;
}

}  // namespace

cv::Rect SpriteRegion(const Sprite& sprite, const cv::Size& picture, double psf_sigma_px) {
  cv::Rect region;
  const int margin = 1 + static_cast<int>(std::ceil(5 * psf_sigma_px));
  for (const SpriteInstant& instant : sprite.instants) region |= PixelsOf(instant.outline, margin, picture);
  return region;
}

SpriteCoverage CoverageOf(const Sprite& sprite, const cv::Size& picture, double psf_sigma_px, const Cover& cover) {
  SpriteCoverage out;
  out.region = SpriteRegion(sprite, picture, psf_sigma_px);
  if (out.region.empty()) {
    out.covered = 1;
    return out;
  }
  const std::size_t count = sprite.instants.size();
  const double weight = 1.0 / static_cast<double>(count);
  if (!cover) {
    const FineCoverage all = Draw(sprite, 0, count - 1, out.region, weight);
    out.area = all.area;
    out.dark = all.dark;
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      FineCoverage one = Draw(sprite, i, i, out.region, weight);
      const cv::Mat hidden = cover(out.region, i);
      if (!hidden.empty()) {
        const cv::Mat open = 1 - Finer(hidden);
        one.area = one.area.mul(open);
        if (!one.dark.empty()) one.dark = one.dark.mul(open);
      }
      Accumulate(out.area, one.area);
      Accumulate(out.dark, one.dark);
    }
  }
  double whole = 0;
  for (const SpriteInstant& instant : sprite.instants)
    whole += weight * kCells * kCells * std::abs(SignedArea(instant.outline));
  out.covered = std::clamp(1 - cv::sum(out.area)[0] / whole, 0.0, 1.0);
  return out;
}

cv::Mat LightOf(const Sprite& sprite, const SpriteCoverage& coverage, const Canvas& under, double psf_sigma_px) {
  const int channels = under.image.channels();
  const cv::Mat kernel = CellKernel(psf_sigma_px);
  std::vector<cv::Mat> planes;
  for (int channel = 0; channel < channels; ++channel) {
    cv::Mat below, light, pixels;
    cv::resize(ChannelUnder(coverage, under, channel), below, coverage.area.size(), 0, 0, cv::INTER_NEAREST);
    light = Emitted(sprite, coverage, channels, channel) - coverage.area.mul(below);
    cv::sepFilter2D(light, light, CV_32F, kernel, kernel, cv::Point(-1, -1), 0, cv::BORDER_CONSTANT);
    cv::resize(light, pixels, coverage.region.size(), 0, 0, cv::INTER_AREA);
    planes.push_back(pixels);
  }
  cv::Mat merged;
  cv::merge(planes, merged);
  return merged;
}

void PaintUnder(const Sprite& sprite, const SpriteCoverage& coverage, Canvas& under) {
  const int channels = under.image.channels();
  cv::Mat area;
  cv::resize(coverage.area, area, coverage.region.size(), 0, 0, cv::INTER_AREA);
  cv::Mat target = under.image(coverage.region - under.corner);
  for (int channel = 0; channel < channels; ++channel) {
    cv::Mat emitted;
    cv::resize(Emitted(sprite, coverage, channels, channel), emitted, coverage.region.size(), 0, 0, cv::INTER_AREA);
    const cv::Mat below = ChannelUnder(coverage, under, channel);
    cv::insertChannel(below - below.mul(area) + emitted, target, channel);
  }
}

cv::Mat PixelKernel(double psf_sigma_px) {
  const cv::Mat cells = CellKernel(psf_sigma_px);
  const int half_cells = cells.cols / 2, half = (half_cells + kCells - 1) / kCells + 1;
  cv::Mat kernel = cv::Mat::zeros(1, 2 * half + 1, CV_64FC1);
  for (int source = 0; source < kCells; ++source)
    for (int i = -half_cells; i <= half_cells; ++i) {
      const int pixel = static_cast<int>(std::floor(double(source + i) / kCells));
      kernel.at<double>(pixel + half) += cells.at<double>(i + half_cells) / kCells;
    }
  return kernel;
}

}  // namespace lake::synth
