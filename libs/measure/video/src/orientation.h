// How a stored picture is turned and mirrored to stand as players show it.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace lake::video {

struct Orientation {
  // The picture as shown is the stored one transposed, then flipped.
  bool transpose = false;
  bool flip_x = false;  // left and right exchanged
  bool flip_y = false;  // top and bottom exchanged

  bool IsIdentity() const { return !transpose && !flip_x && !flip_y; }
  bool IsMirrored() const { return transpose != (flip_x != flip_y); }

  // Clockwise, 0, 90, 180 or 270; of a mirrored picture: the rotation before left and right are exchanged.
  int RotationDeg() const;

  // Turned on by quarters of a turn, clockwise.
  Orientation TurnedOn(int quarters) const;

  // The turned picture; the stored one itself if there is nothing to turn.
  cv::Mat Apply(const cv::Mat& stored) const;
};

// From a display matrix as MP4 has it (libavutil/display.h: x' = a x + c y, y' = b x + d y, 16.16 fixed point in
// matrix[0], [1], [3], [4]). Angles within 1° of a multiple of 90° count as such; nothing for others. A matrix of zeros
// changes nothing.
std::optional<Orientation> OrientationFromDisplayMatrix(const std::int32_t (&matrix)[9]);

}  // namespace lake::video
