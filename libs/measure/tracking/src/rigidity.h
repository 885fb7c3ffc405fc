// How constant the distance between two tracklets stays: by this a leg differs from all else that shines.
#pragma once

#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "lake/tracking/tracklet.h"

namespace lake::tracking {

struct PairDistance {
  int frames = 0;                                      // in which both were seen (of those looked at)
  double mean = 0;                                     // metric units
  double deviation = 0;                                // standard deviation over mean
  Eigen::Vector2d mean_way = Eigen::Vector2d::Zero();  // from the first to the second, metric units
};

// Tracklets with their positions in metric units, and the distances between those seen at one time, computed once each.
class MetricTracklets {
 public:
  MetricTracklets(const std::vector<Tracklet>& tracklets,
                  const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& metric_from_px);

  const Tracklet& operator[](std::size_t i) const { return (*tracklets_)[i]; }
  std::size_t size() const { return tracklets_->size(); }
  const std::vector<Eigen::Vector2d>& Metric(std::size_t i) const { return metric_[i]; }  // one per sample
  double Extent(std::size_t i) const;                                                     // metric units
  double Range(std::size_t i, const Eigen::Vector2d& along) const;                        // of its places
  double ExtentIn(std::size_t i, double from_s, double to_s) const;                       // of those in this time

  // Range of the way from one to the other along a direction, while both are seen.
  double WayRange(std::size_t from, std::size_t to, const Eigen::Vector2d& along) const;

  const PairDistance& Distance(std::size_t i, std::size_t j) const;  // its way is that from the lower index
  Eigen::Vector2d MeanWay(std::size_t from, std::size_t to) const;   // while both were seen

 private:
  PairDistance Measure(std::size_t i, std::size_t j) const;

  const std::vector<Tracklet>* tracklets_;
  std::vector<std::vector<Eigen::Vector2d>> metric_;
  mutable std::map<std::pair<std::size_t, std::size_t>, PairDistance> distances_;
};

// Frames in which both tracklets have samples.
int CommonFrames(const Tracklet& a, const Tracklet& b);

}  // namespace lake::tracking
