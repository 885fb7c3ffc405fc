#include "overlay_inset.h"

#include <cmath>
#include <cstdint>

namespace lake::overlay {
namespace {

// B, G, R, x as cairo has it; black beyond the picture's edge.
cv::Mat CopyAround(const cv::Mat& luma, const cv::Rect& area) {
  cv::Mat copy(area.size(), CV_8UC4, cv::Scalar(0, 0, 0, 255));
  const cv::Rect inside = area & cv::Rect(0, 0, luma.cols, luma.rows);
  for (int y = inside.y; y < inside.y + inside.height; ++y)
    for (int x = inside.x; x < inside.x + inside.width; ++x) {
      const std::uint8_t grey = luma.at<std::uint8_t>(y, x);
      copy.at<cv::Vec4b>(y - area.y, x - area.x) = {grey, grey, grey, 255};
    }
  return copy;
}

}  // namespace

void DrawMagnified(OverlayLayer& layer, const cv::Mat& luma, const Eigen::Vector2d& centre, double half_px,
                   const cv::Rect2d& square) {
  constexpr int kRoom_px = 2;  // for interpolation at the edges
  const int side = 2 * (static_cast<int>(std::ceil(half_px)) + kRoom_px) + 1;
  const cv::Rect area(static_cast<int>(std::lround(centre.x())) - side / 2,
                      static_cast<int>(std::lround(centre.y())) - side / 2, side, side);
  cv::Mat piece = CopyAround(luma, area);
  cairo_t* draw = layer.Context();
  cairo_surface_t* surface = cairo_image_surface_create_for_data(piece.data, CAIRO_FORMAT_RGB24, piece.cols, piece.rows,
                                                                 static_cast<int>(piece.step));
  cairo_save(draw);
  cairo_rectangle(draw, square.x, square.y, square.width, square.height);
  cairo_clip(draw);
  // Pixel centres are at a half for cairo.
  cairo_translate(draw, square.x + square.width / 2, square.y + square.height / 2);
  cairo_scale(draw, square.width / (2 * half_px), square.height / (2 * half_px));
  cairo_set_source_surface(draw, surface, area.x - centre.x() - 0.5, area.y - centre.y() - 0.5);
  cairo_paint(draw);
  cairo_restore(draw);
  cairo_surface_destroy(surface);
  layer.Touch(square);
}

}  // namespace lake::overlay
