#include "lake/overlay/knees_picture.h"

#include <algorithm>
#include <cmath>

#include "page.h"

namespace lake::overlay {
namespace {

using Eigen::Vector2d;

constexpr double kKneesWidth = 640, kKneesHeight = 480, kKneesText = 20;
constexpr Colour kKneeRing = {1, 0.75, 0.25}, kJointRing = {0.95, 0.6, 0.8}, kWay = {1, 1, 1};

// The leg with some room, of the page's proportions, within the frame.
cv::Rect PartWithLeg(const KneesPicture& picture) {
  Vector2d low = picture.knee.cwiseMin(picture.joint), high = picture.knee.cwiseMax(picture.joint);
  for (const Vector2d& marker : picture.leg) {
    low = low.cwiseMin(marker);
    high = high.cwiseMax(marker);
  }
  constexpr double kRoom = 1.3;
  const Vector2d size = kRoom * (high - low), middle = (low + high) / 2;
  const double width =
                   std::min({std::max(size.x(), size.y() * kKneesWidth / kKneesHeight),
                             static_cast<double>(picture.frame.cols), picture.frame.rows * kKneesWidth / kKneesHeight}),
               height = width * kKneesHeight / kKneesWidth;
  const auto from = [](double centre, double length, int limit) {
    return static_cast<int>(std::clamp(centre - length / 2, 0.0, limit - length));
  };
  return {from(middle.x(), width, picture.frame.cols), from(middle.y(), height, picture.frame.rows),
          static_cast<int>(width), static_cast<int>(height)};
}

}  // namespace

cv::Mat DrawKnees(const KneesPicture& picture) {
  const cv::Rect part = PartWithLeg(picture);
  const double scale = kKneesWidth / part.width;
  Page page(static_cast<int>(kKneesWidth), static_cast<int>(std::floor(part.height * scale)), kKneesText);
  page.Paint(picture.frame(part), scale);
  const auto place = [&](const Vector2d& px) {
    return Vector2d(scale * (px.x() + 0.5 - part.x), scale * (px.y() + 0.5 - part.y));
  };
  const Vector2d knee = place(picture.knee), joint = place(picture.joint);
  constexpr double kRing = 11, kGap = 16;
  page.Line(knee.x(), knee.y(), joint.x(), joint.y(), kWay);
  page.Circle(knee.x(), knee.y(), kRing, kKneeRing, true);
  page.Circle(joint.x(), joint.y(), kRing, kJointRing, true);
  // Names on the sides that look away from each other, the distance beside the middle.
  const bool knee_is_left = knee.x() < joint.x();
  const auto write = [&](const std::string& text, const Vector2d& at, bool left, const Colour& colour) {
    page.WriteOver(text, left ? at.x() - kGap - page.WidthOf(text) : at.x() + kGap, at.y() + kKneesText / 3, colour);
  };
  const bool are_apart = std::abs(knee.y() - joint.y()) > kKneesText;
  write("knee", knee, knee_is_left, kKneeRing);
  write("exoskeleton", joint, !knee_is_left, kJointRing);
  const Vector2d beside = (knee + joint) / 2 + (are_apart ? Vector2d::Zero() : Vector2d(0, -2 * kKneesText));
  write(picture.distance, beside, !knee_is_left, kWay);
  return page.Picture();
}

}  // namespace lake::overlay
