// A transparent layer to draw on, laid over a YUV picture. Only where something was drawn does it cost anything.
#pragma once

#include <cairo.h>

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace lake::overlay {

class OverlayLayer {
 public:
  // Even sides, px; the matrix of the pictures, BT.709 or BT.601.
  OverlayLayer(cv::Size size, bool bt709);

  cairo_t* Context() const { return context_.get(); }
  cv::Size Size() const { return size_; }

  // Whoever draws says where; what is drawn elsewhere may not appear.
  void Touch(const cv::Rect2d& area);

  // Lays the layer over the picture (VideoFrame::preview of the same size) and clears it.
  void BlendOnto(cv::Mat& i420);

 private:
  struct Delete {
    void operator()(cairo_t* context) const { cairo_destroy(context); }
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  };
  static constexpr int kTile_px = 16;

  // Y, Cb and Cr as offset + weights · (B, G, R); the offset counts by the share that is covered.
  struct YuvMatrix {
    std::array<int, 3> y, u, v;  // 16.16 fixed point
  };
  // Of even sides, as all are; leaves it clear.
  void Blend(const cv::Rect& area, cv::Mat& i420);

  cv::Size size_, tiles_;
  cv::Mat argb_;  // CV_8UC4 B, G, R, A, colours already multiplied by alpha
  std::unique_ptr<cairo_surface_t, Delete> surface_;
  std::unique_ptr<cairo_t, Delete> context_;
  std::vector<bool> touched_;
  YuvMatrix matrix_;
};

}  // namespace lake::overlay
