#include "orientation.h"

#include <cmath>
#include <opencv2/core.hpp>

namespace lake::video {

int Orientation::RotationDeg() const {
  const bool left_right_last = IsMirrored() ? !flip_x : flip_x;  // what remains to flip once the mirroring is taken off
  if (transpose) return left_right_last ? 90 : 270;
  return left_right_last ? 180 : 0;
}

Orientation Orientation::TurnedOn(int quarters) const {
  Orientation turned = *this;
  for (int i = 0; i < quarters; ++i)
    turned = {.transpose = !turned.transpose, .flip_x = !turned.flip_y, .flip_y = turned.flip_x};
  return turned;
}

cv::Mat Orientation::Apply(const cv::Mat& stored) const {
  if (IsIdentity()) return stored;
  cv::Mat turned;
  if (transpose)
    cv::transpose(stored, turned);
  else
    turned = stored;
  if (flip_x || flip_y) {
    const int axis = flip_x && flip_y ? -1 : flip_x ? 1 : 0;
    cv::Mat flipped;
    cv::flip(turned, flipped, axis);
    return flipped;
  }
  return turned;
}

std::optional<Orientation> OrientationFromDisplayMatrix(const std::int32_t (&matrix)[9]) {
  const double a = matrix[0], b = matrix[1], c = matrix[3], d = matrix[4];
  const double along = std::hypot(a, d), across = std::hypot(b, c);
  if (along == 0 && across == 0) return Orientation{};
  const double sin_1_deg = std::sin(CV_PI / 180);
  if (across <= along * sin_1_deg) return Orientation{.transpose = false, .flip_x = a < 0, .flip_y = d < 0};
  if (along <= across * sin_1_deg) return Orientation{.transpose = true, .flip_x = c < 0, .flip_y = b < 0};
  return std::nullopt;
}

}  // namespace lake::video
