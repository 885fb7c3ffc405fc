// The picture of lake check, as those see it who cannot tell its colours.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "lake/overlay/pictures.h"

namespace lake::overlay {
namespace {

constexpr int kFrameWidth_px = 960;  // of the picture's 1600

cv::Mat1b WithoutColour(const CheckPicture& picture) {
  cv::Mat1b grey;
  cv::cvtColor(DrawCheckPicture(picture), grey, cv::COLOR_BGR2GRAY);
  return grey;
}

CheckPicture Dark(std::vector<CheckPicture::Spot> spots) {
  return {.frame = cv::Mat1b(540, kFrameWidth_px, uchar{0}),
          .spots = std::move(spots),
          .lines = {},
          .title = "",
          .legend = ""};
}

// The share of a circle's line that is drawn.
double DrawnShare(const cv::Mat1b& grey, const cv::Point2d& centre, double radius) {
  int drawn = 0;
  for (int degree = 0; degree < 360; ++degree) {
    const double angle = degree * std::numbers::pi / 180;
    drawn += grey(cv::Point(centre + radius * cv::Point2d(std::cos(angle), std::sin(angle)))) > 60;
  }
  return drawn / 360.0;
}

TEST(CheckPicture, EachGradeHasASignOfItsOwnShape) {
  CheckPicture picture = Dark({});
  for (int grade = 0; grade < 4; ++grade) picture.lines.push_back({.text = "12.3 px", .advice = "", .grade = grade});
  cv::Mat1b ink;
  cv::threshold(WithoutColour(picture).colRange(kFrameWidth_px + 8, kFrameWidth_px + 36), ink, 160, 1,
                cv::THRESH_BINARY_INV);
  std::vector<cv::Mat1b> signs;
  for (int grade = 0; grade < 4; ++grade) signs.push_back(ink.rowRange(40 + 25 * grade, 62 + 25 * grade));
  for (std::size_t a = 0; a < signs.size(); ++a) {
    EXPECT_GT(cv::countNonZero(signs[a]), 10) << a;
    for (std::size_t b = 0; b < a; ++b) {
      // Of the same shape they would differ where lines are smoothed alone, by a few px.
      EXPECT_GT(cv::countNonZero(signs[a] != signs[b]), 0.5 * cv::countNonZero(signs[a])) << a << " and " << b;
    }
  }
}

TEST(CheckPicture, NamedMarkersAreSolidAndHaveTheirNamesOtherSpotsAreDashed) {
  constexpr double kRadius_px = 20, kRing_px = 1.8 * kRadius_px;
  const cv::Mat1b named = WithoutColour(Dark({{{200, 200}, kRadius_px, "knee"}})),
                  other = WithoutColour(Dark({{{200, 200}, kRadius_px, ""}}));
  const cv::Point2d centre(200.5, 200.5);
  EXPECT_EQ(DrawnShare(named, centre, kRing_px), 1);
  EXPECT_NEAR(DrawnShare(other, centre, kRing_px), 4.0 / 7, 0.15);  // dashes of 4 px, 3 px apart, with their soft ends
  const cv::Rect beside(242, 180, 80, 40);
  EXPECT_GT(cv::countNonZero(named(beside) > 60), 50);
  EXPECT_EQ(cv::countNonZero(other(beside) > 60), 0);
}

TEST(CheckPicture, ANameStaysWithinTheFrame) {
  CheckPicture picture = Dark({{{kFrameWidth_px - 30, 200}, 8, "exo_knee"}});
  const cv::Mat1b named = WithoutColour(picture);
  EXPECT_EQ(cv::countNonZero(named.colRange(kFrameWidth_px, named.cols) < 255), 0);
  EXPECT_GT(cv::countNonZero(named.colRange(kFrameWidth_px - 140, kFrameWidth_px - 50) > 60), 100);
}

}  // namespace
}  // namespace lake::overlay
