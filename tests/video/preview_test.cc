// Small previews against means of the luma plane and the reader's own BGR; writing them unconverted.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "lake/video/halve.h"
#include "lake/video/video_writer.h"
#include "video_files.h"

namespace lake {
namespace {

using test::Ffmpeg;
using test::Quote;
using test::ReadAll;
using test::TestPicture;

// Largest distance between the preview's Y and factor × (mean of 2×2 of the luma) + offset.
double WorstOfHalved(const cv::Mat& preview, const cv::Mat& luma, double factor, double offset) {
  double worst = 0;
  for (int y = 0; y < luma.rows / 2; ++y)
    for (int x = 0; x < luma.cols / 2; ++x) {
      const cv::Mat block = luma(cv::Rect(2 * x, 2 * y, 2, 2));
      const double expected = factor * cv::sum(block)[0] / 4 + offset;
      worst = std::max(worst, std::abs(preview.at<std::uint8_t>(y, x) - expected));
    }
  return worst;
}

TEST(PreviewTest, HalfIsTheMeanOfFour) {
  const TemporaryFolder folder;
  const auto path = folder / "video.mp4";
  Ffmpeg(TestPicture() + test::kH264 + Quote(path));
  const auto whole = ReadAll(path), small = ReadAll(path, {.preview_max_width_px = 160});
  ASSERT_EQ(small.frames.size(), whole.frames.size());
  EXPECT_EQ(small.Stamps(), whole.Stamps());
  EXPECT_EQ(small.frames[7].preview.size(), cv::Size(160, 180));
  EXPECT_TRUE(small.frames[7].luma.empty());
  EXPECT_LE(WorstOfHalved(small.frames[7].preview, whole.frames[7].luma, 1, 0), 0.51);  // rounding
}

TEST(PreviewTest, FullRangeBecomesLimited) {
  const TemporaryFolder folder;
  const auto path = folder / "video.mp4";
  Ffmpeg(TestPicture() + "-c:v libx264 -pix_fmt yuvj420p " + Quote(path));
  const auto whole = ReadAll(path), small = ReadAll(path, {.preview_max_width_px = 160});
  EXPECT_LE(WorstOfHalved(small.frames[7].preview, whole.frames[7].luma, 219 / 255.0, 16), 0.52);
}

cv::Mat Noise(int rows, int cols) {
  cv::Mat picture(rows, cols, CV_8UC1);
  cv::RNG rng(4321);
  rng.fill(picture, cv::RNG::UNIFORM, 0, 256);
  return picture;
}

// To the last bit; widths that no vector divides, and a part of a picture, whose rows begin anywhere.
TEST(HalveTest, IsTheMeanOfAreas) {
  for (const auto& [rows, cols] : {std::pair(2, 2), std::pair(7, 33), std::pair(48, 130), std::pair(9, 301)}) {
    const cv::Mat picture = Noise(rows + 1, cols + 3)(cv::Rect(3, 1, cols, rows));
    cv::Mat half, expected;
    video::Halve(picture, half);
    cv::resize(picture(cv::Rect(0, 0, cols / 2 * 2, rows / 2 * 2)), expected, {}, 0.5, 0.5, cv::INTER_AREA);
    EXPECT_EQ(cv::norm(half, expected, cv::NORM_INF), 0) << rows << "x" << cols;
  }
}

// The nearest level; 16 bits hold 1/256 of one, which halves may fall within.
TEST(HalveTest, LimitedRangeIsTheNearestLevel) {
  const cv::Mat picture = Noise(64, 162);
  for (const bool is_luma : {true, false}) {
    cv::Mat half;
    video::HalveToLimitedRange(picture, is_luma ? video::Sample::kLuma : video::Sample::kChroma, half);
    const double factor = (is_luma ? 219 : 224) / 255.0, offset = is_luma ? 16 : 128 * (1 - factor);
    EXPECT_LE(WorstOfHalved(half, picture, factor, offset), 0.5 + 1.5 / 256) << is_luma;
  }
  cv::Mat half;
  for (const auto& [level, expected] : {std::pair(0, 16), std::pair(255, 235)}) {
    video::HalveToLimitedRange(cv::Mat(4, 4, CV_8UC1, cv::Scalar(level)), video::Sample::kLuma, half);
    EXPECT_EQ(cv::norm(half, cv::Mat(2, 2, CV_8UC1, cv::Scalar(expected)), cv::NORM_INF), 0) << level;
  }
}

// Any other ratio is swscale's: the mean level stays, sides are even.
TEST(PreviewTest, AnySizeAndFormat) {
  const TemporaryFolder folder;
  for (const char* format : {"yuv420p", "yuv444p", "yuv420p10le", "gbrp"}) {
    const auto path = folder / (std::string(format) + ".mkv");
    Ffmpeg(TestPicture("size=321x241:rate=30:duration=0.2") + "-c:v ffv1 -pix_fmt " + format +
           (std::string(format) == "yuv420p" ? " -vf scale=322:242 " : " ") + Quote(path));
    const auto small = ReadAll(path, {.preview_max_width_px = 200}), whole = ReadAll(path, {.colour = true});
    const cv::Mat& preview = small.frames.front().preview;
    EXPECT_EQ(preview.size(), cv::Size(200, 225)) << format;
    const cv::Scalar bgr = cv::mean(whole.frames.front().bgr);
    const bool bt709 = small.info.bt709;
    const double kr = bt709 ? 0.2126 : 0.299, kb = bt709 ? 0.0722 : 0.114;
    const double luma = kb * bgr[0] + (1 - kr - kb) * bgr[1] + kr * bgr[2];
    EXPECT_NEAR(cv::mean(preview.rowRange(0, 150))[0], 16 + luma * 219 / 255, 2) << format;  // clipped colours
  }
}

TEST(PreviewTest, IsWrittenWithoutConversion) {
  const TemporaryFolder folder;
  const auto path = folder / "video.mp4", copy = folder / "copy.mp4";
  Ffmpeg(TestPicture() + test::kH264 + Quote(path));
  const auto small = ReadAll(path, {.preview_max_width_px = 200});
  video::VideoWriter writer(copy,
                            {.width = 200, .height = 150, .lossless = true, .i420 = true, .bt709 = small.info.bt709});
  for (const video::VideoFrame& frame : small.frames) writer.Write(frame.preview, frame.time_s);
  writer.Finish();
  const auto read = ReadAll(copy, {.preview_max_width_px = 200});
  ASSERT_EQ(read.frames.size(), small.frames.size());
  EXPECT_EQ(read.info.bt709, small.info.bt709);
  EXPECT_EQ(test::LargestDifference(read.frames[9].preview.rowRange(0, 150), small.frames[9].preview.rowRange(0, 150)),
            0);
}

TEST(PreviewTest, WriterTakesNoOtherShape) {
  const TemporaryFolder folder;
  video::VideoWriter writer(folder / "video.mp4", {.width = 64, .height = 48, .i420 = true});
  EXPECT_THROW(writer.Write(cv::Mat(48, 64, CV_8UC1, cv::Scalar(0)), 0), Error);
}

}  // namespace
}  // namespace lake
