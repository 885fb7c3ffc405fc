#include <gmock/gmock.h>

#include "lake/video/image.h"
#include "lake/video/video_files.h"
#include "video_files.h"

namespace lake::test {
namespace {

using ::testing::DoubleNear;
using ::testing::HasSubstr;
using ::testing::Optional;
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
    const Recording recording = ReadAll(pattern, {.colour = true, .capture_rate_hz = 120});
    EXPECT_THAT(recording.Stamps(), Pointwise(DoubleNear(1e-12), Regular(0, 120, 12)));
    EXPECT_EQ(recording.info.frames, 12);
    EXPECT_EQ(recording.info.frame_rate_hz, 120);
    const auto one = folder / fmt::format("one.{}", extension);  // ffmpeg would take the % of the folder for a pattern
    std::filesystem::copy_file(frames / fmt::format("f00019.{}", extension), one);
    const auto raw = RawFrames(one, "bgr24");
    const double lossy = std::string(extension) == "jpg" ? 20 : 0;  // JPEG: swscale and the decoder round differently
    EXPECT_LE(LargestDifference(recording.frames[2].bgr, RawFrame(raw, 0, {160, 120}, CV_8UC3)), lossy);
  }
}

// 300 pictures of a 60 Hz recording took twice their time where 30 Hz were assumed.
TEST(ImageSequence, HasNoTimesButByItsRate) {
  const TemporaryFolder folder;
  const auto pattern = folder / "%05d.png";
  Ffmpeg(TestPicture("size=64x48:rate=30:duration=0.4") + Quote(pattern));
  EXPECT_THAT(ErrorOf(pattern), HasSubstr("an image sequence has no times: say at how many Hz"));
  EXPECT_FALSE(video::HasTimes(pattern));
  EXPECT_EQ(video::StampsInContainer(pattern), std::nullopt);
  EXPECT_THAT(video::StampsInContainer(pattern, {.capture_rate_hz = 60, .start_s = 3 / 60.0, .end_s = 5 / 60.0}),
              Optional(Pointwise(DoubleNear(1e-12), {3 / 60.0, 4 / 60.0, 5 / 60.0})));
  EXPECT_TRUE(video::HasTimes(folder / "00001.png"));  // one picture takes no time
  EXPECT_EQ(ErrorOf(folder / "00001.png"), "");
  EXPECT_FALSE(video::ReadImage(pattern, false).empty());
}

TEST(ImageSequence, IsReadFromAnyPictureOn) {
  const TemporaryFolder folder;
  const auto pattern = folder / "%05d.png";
  Ffmpeg(TestPicture("size=64x48:rate=30:duration=0.4") + Quote(pattern));
  const video::VideoReaderOptions whole{.capture_rate_hz = 60}, part{.capture_rate_hz = 60, .seek_s = 7 / 60.0};
  const Recording all = ReadAll(pattern, whole), later = ReadAll(pattern, part);
  EXPECT_THAT(later.Stamps(), Pointwise(DoubleNear(1e-12), Regular(7 / 60.0, 60, 5)));
  EXPECT_EQ(LargestDifference(later.frames.front().luma, all.frames[7].luma), 0);
  std::filesystem::resize_file(folder / "00010.png", 200);
  EXPECT_THAT(ErrorOf(pattern, part), HasSubstr("00010.png"));
}

TEST(ImageSequence, RefusesGapsAndPatternsThatFitNothing) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=64x48:rate=30:duration=0.4") + Quote(folder / "%05d.png"));
  EXPECT_EQ(ErrorOf(folder / "%05d.png", {.capture_rate_hz = 30}), "");
  std::filesystem::remove(folder / "00007.png");
  EXPECT_THAT(ErrorOf(folder / "%05d.png"), HasSubstr("00007.png is missing, but 00008.png is there"));
  EXPECT_THAT(ErrorOf(folder / "%04d.png"), HasSubstr("no file fits this pattern"));
  EXPECT_THAT(ErrorOf(folder / "%s.png"), HasSubstr("neither a file nor a pattern"));
  EXPECT_THAT(ErrorOf(folder / "%d_%d.png"), HasSubstr("neither a file nor a pattern"));
  EXPECT_THAT(ErrorOf(folder / "nowhere" / "%d.png"), HasSubstr("the folder cannot be read"));
}

}  // namespace
}  // namespace lake::test
