// A marker of each kind, pointed at beside its place.
#include "lake/review/snap.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "lake/camera/aruco_opencv.h"
#include "lake/core/error.h"

namespace lake::review {
namespace {

using Eigen::Vector2d;

constexpr double kNear_px = 0.2;  // drawn without noise; what antialiasing and the fit's model of a disc differ by

// A disc in the middle of this pixel, drawn eight times larger.
cv::Mat Disc(const cv::Point& middle, double radius_px, const cv::Scalar& colour, const cv::Scalar& ground) {
  constexpr int kFiner = 8;
  cv::Mat fine(200 * kFiner, 300 * kFiner, CV_8UC3, ground), picture;
  const cv::Point centre(kFiner * middle.x + kFiner / 2, kFiner * middle.y + kFiner / 2);
  cv::circle(fine, centre, static_cast<int>(kFiner * radius_px), colour, cv::FILLED);
  cv::resize(fine, picture, {300, 200}, 0, 0, cv::INTER_AREA);
  return picture;
}

std::optional<tracking::MarkerDetection> Snap(const cv::Mat& bgr, const Vector2d& place,
                                              const tracking::DetectorMaker& detector) {
  video::VideoFrame frame;
  cv::cvtColor(bgr, frame.luma, cv::COLOR_BGR2GRAY);
  return SnapToMarker(frame, place, 20, detector, [&] { return bgr; });
}

tracking::DetectorMaker Reflective() {
  return [](const auto& near) { return tracking::MakeReflectiveDetector(tracking::Polarity::kBright, near); };
}

TEST(Snap, ToABrightDisc) {
  const cv::Mat picture = Disc({120, 80}, 6, {250, 250, 250}, {40, 40, 40});
  const auto found = Snap(picture, {131, 72}, Reflective());
  ASSERT_TRUE(found);
  EXPECT_LT((found->position - Vector2d(120, 80)).norm(), kNear_px);
  EXPECT_FALSE(Snap(picture, {145, 80}, Reflective())) << "out of reach";
  EXPECT_FALSE(Snap(picture, {1e9, 80}, Reflective())) << "out of the picture";
}

TEST(Snap, ToAColouredDisc) {
  const tracking::MarkerHue hue = tracking::HueOfColor(tracking::ParseMarkerColor("#00C832"), false);
  const tracking::DetectorMaker green = [&](const auto& near) { return tracking::MakeColorDetector({hue}, near); };
  const cv::Mat picture = Disc({120, 80}, 6, {50, 200, 0}, {110, 110, 110});
  const auto found = Snap(picture, {131, 72}, green);
  ASSERT_TRUE(found);
  EXPECT_LT((found->position - Vector2d(120, 80)).norm(), kNear_px);
  EXPECT_FALSE(Snap(Disc({120, 80}, 6, {50, 50, 220}, {110, 110, 110}), {131, 72}, green)) << "red";
}

// Smooth noise, as of a cloth; its part round (120, 80) is the marker.
TEST(Snap, ToAPatchAsItWasInAnotherFrame) {
  cv::Mat noise(200, 300, CV_8UC1), before, now;
  cv::RNG random(5);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, before, {}, 2);
  const Vector2d moved(6, -5);  // whole pixels: the same picture, not interpolated
  const cv::Mat by = (cv::Mat_<double>(2, 3) << 1, 0, moved.x(), 0, 1, moved.y());
  cv::warpAffine(before, now, by, before.size(), cv::INTER_NEAREST, cv::BORDER_REFLECT);
  video::VideoFrame frame;
  frame.index = 7;
  frame.luma = now;
  const auto snap = [&](const Vector2d& place) {
    return SnapToMarker(frame, place, 20, DetectorOfPatch(before, {120, 80}), [] { return cv::Mat(); });
  };
  const auto found = snap({118, 83});
  ASSERT_TRUE(found);
  EXPECT_LT((found->position - Vector2d(120, 80) - moved).norm(), 0.01) << "its fit ends at 0.001 px";
  EXPECT_FALSE(snap({150, 80})) << "out of reach";
  frame.luma = cv::Mat(200, 300, CV_8UC1, cv::Scalar(90));
  EXPECT_FALSE(snap({118, 83})) << "it is not there";
  EXPECT_THROW(DetectorOfPatch(frame.luma, {120, 80})({}), Error) << "nothing to be found again";
}

TEST(Snap, ToAnArucoMarker) {
  const tracking::DetectorMaker aruco = [](const auto&) { return tracking::MakeArucoDetector("4X4_50", {}); };
  cv::Mat picture(200, 300, CV_8UC3, cv::Scalar(220, 220, 220));
  cv::Mat marker = camera::DrawArucoMarker(camera::PredefinedArucoDictionary(cv::aruco::DICT_4X4_50), 7, 60);
  cv::cvtColor(marker, marker, cv::COLOR_GRAY2BGR);
  marker.copyTo(picture(cv::Rect(90, 50, 60, 60)));
  const auto found = Snap(picture, {128, 70}, aruco);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->identity, 7);
  EXPECT_LT((found->position - Vector2d(119.5, 79.5)).norm(), kNear_px) << "pixels 90 to 149";
}

}  // namespace
}  // namespace lake::review
