// Scenes of markers before an even background, small and quick to render.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "lake/synth/scene.h"

namespace lake::test {

// Position = start + velocity t + acceleration t² / 2, for any number of markers.
class ParabolicMotion : public synth::MarkerMotion {
 public:
  struct Track {
    std::string name;
    Eigen::Vector2d start_mm{0, 0}, velocity_mm_s{0, 0}, acceleration_mm_s2{0, 0};
  };
  explicit ParabolicMotion(std::vector<Track> tracks, double duration_s = 1)
      : tracks_(std::move(tracks)), duration_s_(duration_s) {
    for (const Track& track : tracks_) names_.push_back(track.name);
  }
  const std::vector<std::string>& Names() const override { return names_; }
  motion::Facing FacingInImage() const override { return motion::Facing::kRight; }
  double DurationS() const override { return duration_s_; }
  std::vector<Eigen::Vector2d> At(double t) const override {
    std::vector<Eigen::Vector2d> positions;
    for (const Track& track : tracks_)
      positions.push_back(track.start_mm + t * track.velocity_mm_s + 0.5 * t * t * track.acceleration_mm_s2);
    return positions;
  }

 private:
  std::vector<Track> tracks_;
  std::vector<std::string> names_;
  double duration_s_;
};

inline synth::SceneOptions PlainOptions(std::uint64_t seed = 1) {
  synth::SceneOptions options;
  options.seed = seed;
  options.room = options.body = false;
  options.width_px = 160;
  options.height_px = 120;
  return options;
}

inline std::shared_ptr<synth::MarkerMotion> OneMarker(const Eigen::Vector2d& at_mm,
                                                      const Eigen::Vector2d& velocity = {0, 0},
                                                      const Eigen::Vector2d& acceleration = {0, 0}) {
  return std::make_shared<ParabolicMotion>(
      std::vector<ParabolicMotion::Track>{{"ball", at_mm, velocity, acceleration}});
}

struct Blob {
  double sum = 0;
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
};

// Sum and centroid of what a picture of one channel holds above an even background.
inline Blob BlobOf(const cv::Mat& image, double background) {
  Blob blob;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const double value = image.at<float>(y, x) - background;
      blob.sum += value;
      blob.centroid += value * Eigen::Vector2d(x, y);
    }
  blob.centroid /= blob.sum;
  return blob;
}

}  // namespace lake::test
