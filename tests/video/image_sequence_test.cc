#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "video_files.h"

namespace lake::test {
namespace {

using ::testing::DoubleNear;
using ::testing::HasSubstr;
using ::testing::Pointwise;

TEST(ImageSequence, IsAVideo) {
  const TemporaryFolder folder;
  const auto frames = folder / "odd %d name";
  std::filesystem::create_directory(frames);
  for (const char* extension : {"png", "jpg", "bmp", "tif"}) {
    SCOPED_TRACE(extension);
    const auto pattern = frames / fmt::format("f%05d.{}", extension);
    const std::string escaped = (folder / "odd %%d name").string() + fmt::format("/f%05d.{}", extension);
    Ffmpeg(TestPicture("size=160x120:rate=30:duration=0.4") + "-start_number 17 " + Quote(escaped));
    const Recording recording = ReadAll(pattern, {.colour = true, .sequence_rate_hz = 120});
    EXPECT_THAT(recording.Stamps(), Pointwise(DoubleNear(1e-12), Regular(0, 120, 12)));
    EXPECT_EQ(recording.info.frames, 12);
    EXPECT_EQ(recording.info.frame_rate_hz, 120);
    EXPECT_THAT(ReadAll(pattern, {.capture_rate_hz = 480}).Stamps(), Pointwise(DoubleNear(1e-12), Regular(0, 480, 12)));
    const auto one = folder / fmt::format("one.{}", extension);  // ffmpeg would take the % of the folder for a pattern
    std::filesystem::copy_file(frames / fmt::format("f00019.{}", extension), one);
    const auto raw = RawFrames(one, "bgr24");
    const double lossy = std::string(extension) == "jpg" ? 20 : 0;  // JPEG: swscale and the decoder round differently
    EXPECT_LE(LargestDifference(recording.frames[2].bgr, RawFrame(raw, 0, {160, 120}, CV_8UC3)), lossy);
  }
}

TEST(ImageSequence, RefusesGapsAndPatternsThatFitNothing) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=64x48:rate=30:duration=0.4") + Quote(folder / "%05d.png"));
  EXPECT_EQ(ErrorOf(folder / "%05d.png"), "");
  std::filesystem::remove(folder / "00007.png");
  EXPECT_THAT(ErrorOf(folder / "%05d.png"), HasSubstr("00007.png is missing, but 00008.png is there"));
  EXPECT_THAT(ErrorOf(folder / "%04d.png"), HasSubstr("no file fits this pattern"));
  EXPECT_THAT(ErrorOf(folder / "%s.png"), HasSubstr("neither a file nor a pattern"));
  EXPECT_THAT(ErrorOf(folder / "%d_%d.png"), HasSubstr("neither a file nor a pattern"));
  EXPECT_THAT(ErrorOf(folder / "nowhere" / "%d.png"), HasSubstr("the folder cannot be read"));
}

}  // namespace
}  // namespace lake::test
