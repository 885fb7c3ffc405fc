// What is drawn over one frame of the recording.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "lake/overlay/overlay_video.h"
#include "lake/video/video_reader.h"
#include "overlay_labels.h"
#include "overlay_layer.h"

namespace lake::overlay {

class OverlayScene {
 public:
  // `shown`: the size of the overlay; the tracks' pixels refer to the video as it was recorded.
  OverlayScene(const OverlayContent& content, const OverlayOptions& options, const video::VideoInfo& recorded,
               cv::Size shown);

  // Lays the drawing for this frame of the file over its preview; the insets show its luma.
  void DrawOnto(video::VideoFrame& frame);

 private:
  struct Colour {
    double r, g, b;
  };
  static Colour MarkerColour(const std::string& name);

  cv::Point2d Shown(const Eigen::Vector2d& recorded_px) const;
  std::optional<std::size_t> TrackRow(std::int64_t frame) const;
  const motion::LegSample* Leg(std::int64_t frame) const;                       // nullptr where nothing is known
  std::optional<cv::Point2d> Place(const char* marker, std::size_t row) const;  // nothing when missing
  const motion::StsEvent* RecentEvent(double time_s) const;

  // Sizes that hold for the whole recording.
  void ChooseDecimals();
  void PlacePanelAndInsets();
  std::vector<cv::Rect2d> LayOut(double width) const;
  std::size_t MarkersWithin(const cv::Rect2d& block) const;

  void DrawTrail(const motion::MarkerTrack& marker, std::size_t row);
  void DrawSkeleton(std::size_t row);
  void DrawMark(const motion::MarkerTrack& marker, const motion::MarkerSample& sample);
  void DrawAngle(std::size_t row, const motion::LegSample& leg);
  // `of` is what the label is of, by which its place is remembered while its text changes.
  void DrawLabel(const std::string& of, const std::string& text, cv::Point2d centre, double radius_px, double alpha);
  void DrawPanel(std::int64_t frame, double time_s, const motion::LegSample* leg);
  void DrawProgress(double y, const motion::LegSample* leg);
  void DrawInset(std::size_t marker, std::optional<std::size_t> row, const cv::Mat& luma);
  void DrawCross(cv::Point2d centre, double inner, double outer, const Colour& colour);  // radii in units
  void DrawEstimate(std::size_t marker, std::size_t row, const cv::Rect2d& square);
  std::string Accuracy(std::size_t marker, std::size_t row) const;  // "0.04 ±0.05 px"

  void Stroke(cv::Point2d from, cv::Point2d to, double width_px);
  void Box(const cv::Rect2d& area, const Colour& colour, double alpha);  // with rounded corners
  void SetColour(const Colour& colour, double alpha = 1);
  void Text(const std::string& text, cv::Point2d left_middle, const Colour& colour);
  double TextWidth(const std::string& text);
  std::string AngleText(const motion::LegSample& leg) const;

  OverlayContent content_;
  OverlayOptions options_;
  cv::Point2d scale_;  // shown px per recorded px
  OverlayLayer layer_;
  cairo_t* draw_;
  OverlayLabels labels_;
  double unit_px_;                // 1 for a picture 720 px high
  double line_height_px_;         // of text
  double middle_to_base_px_ = 0;  // from the middle of a line of text to its baseline
  int decimals_ = 1;              // of angles
  double inset_half_px_;          // of the recording, to either side of the marker
  cv::Rect2d panel_;
  std::vector<cv::Rect2d> insets_;  // one a marker, its lines of text below the square included
};

}  // namespace lake::overlay
