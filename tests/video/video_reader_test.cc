#include "lake/video/video_reader.h"

#include <gmock/gmock.h>

#include <csignal>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/video/video_files.h"
#include "places.h"
#include "turned_film.h"
#include "video_files.h"

namespace lake::test {
namespace {

using ::testing::AllOf;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pointwise;
using ::testing::SizeIs;

// Every stored sample must come back as ffmpeg shows it, in the same number of frames.
void ExpectLumaAsStored(const std::filesystem::path& video) {
  const Recording recording = ReadAll(video);
  const auto raw = RawLuma(video);
  const cv::Size size(recording.info.width, recording.info.height);
  ASSERT_EQ(raw.size(), recording.frames.size() * static_cast<std::size_t>(size.area())) << video;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    ASSERT_EQ(recording.frames[i].index, static_cast<std::int64_t>(i));
    ASSERT_EQ(LargestDifference(recording.frames[i].luma, RawFrame(raw, i, size, CV_8UC1)), 0)
        << video << " frame " << i;
  }
}

TEST(VideoReader, GivesTheStoredLumaOfManyFormats) {
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::string>> formats = {
      {"h264.mp4", kH264},
      {"h264.mkv", kH264},
      {"h264.ts", kH264},
      {"hevc.mp4", "-c:v libx265 -preset ultrafast -x265-params log-level=none -pix_fmt yuv420p"},
      {"vp9.webm", "-c:v libvpx-vp9 -deadline realtime -cpu-used 8 -b:v 1M"},
      {"motion_jpeg.avi", "-c:v mjpeg -q:v 3"},
      {"mpeg4.avi", "-c:v mpeg4 -bf 2 -q:v 3"},
      {"nv12.mkv", "-c:v rawvideo -pix_fmt nv12"},
      {"grey.mkv", "-c:v ffv1 -pix_fmt gray"},
      {"packed.mkv", "-c:v rawvideo -pix_fmt yuyv422"},
      {"yuv444.mov", "-c:v libx264 -preset ultrafast -pix_fmt yuv444p"},
      {"fragmented.mp4", std::string(kH264) + "-movflags frag_keyframe+empty_moov"},
  };
  for (const auto& [name, codec] : formats) {
    SCOPED_TRACE(name);
    Ffmpeg(TestPicture("size=322x242:rate=30:duration=0.7") + codec + " " + Quote(folder / name));
    ExpectLumaAsStored(folder / name);
  }
}

TEST(VideoReader, GivesTheLumaOfOddSizesAndCroppedStreams) {
  const TemporaryFolder folder;
  for (const char* size : {"64x48", "101x77", "854x480", "1918x1078"}) {
    SCOPED_TRACE(size);
    const auto video = folder / fmt::format("{}.mp4", size);
    Ffmpeg(TestPicture(fmt::format("size={}:rate=30:duration=0.2", size)) +
           "-c:v libx264 -preset ultrafast -pix_fmt yuv444p " + Quote(video));
    ExpectLumaAsStored(video);
  }
  // The H.264 stream itself crops 3 columns and 5 rows off its top left corner.
  const auto whole = folder / "whole.mp4", cropped = folder / "cropped.mp4";
  Ffmpeg(TestPicture("size=320x240:rate=30:duration=0.5") + "-c:v libx264 -preset ultrafast -pix_fmt yuv444p " +
         Quote(whole));
  Ffmpeg(fmt::format("-i {} -c copy -bsf:v h264_metadata=crop_left=3:crop_top=5 {}", Quote(whole), Quote(cropped)));
  const Recording a = ReadAll(whole), b = ReadAll(cropped);
  ASSERT_EQ(cv::Size(317, 235), cv::Size(b.info.width, b.info.height));
  EXPECT_EQ(LargestDifference(a.frames[7].luma(cv::Rect(3, 5, 317, 235)), b.frames[7].luma), 0);
}

TEST(VideoReader, RoundsDeepLumaToEightBits) {
  const TemporaryFolder folder;
  for (const char* codec :
       {"-c:v libx265 -preset ultrafast -x265-params log-level=none -pix_fmt yuv420p10le", "-c:v prores"}) {
    const auto video = folder / "deep.mov";
    Ffmpeg(TestPicture("size=320x240:rate=30:duration=0.3") + codec + " " + Quote(video));
    const Recording recording = ReadAll(video);
    ASSERT_THAT(recording.info.pixel_format, HasSubstr("10le"));
    const auto raw = RawFrames(video, "gray10le", "extractplanes=y");
    for (std::size_t i = 0; i < recording.frames.size(); ++i) {
      cv::Mat expected;  // a video level of 10 bits is 4 of 8 bits, in limited range too
      RawFrame(raw, i, {320, 240}, CV_16UC1).convertTo(expected, CV_8U, 0.25);
      ASSERT_EQ(LargestDifference(recording.frames[i].luma, expected), 0);
    }
  }
}

TEST(VideoReader, KeepsTheContainersStamps) {
  const TemporaryFolder folder;
  struct Case {
    std::string name, arguments;
    std::vector<double> stamps;
    double rounding_s;  // of the container's stamps
  };
  std::vector<double> variable = Regular(0.5, 30, 61);  // from frame 30 on all, before every seventh
  std::erase_if(variable, [&, i = 0](double) mutable { return i++, (i - 1) % 7 != 0 && i - 1 < 30; });
  const std::string vfr = "-vf \"select='not(mod(n,7))+gte(n,30)',setpts=PTS+0.5/TB\" -vsync vfr ";
  const std::string picture = TestPicture("size=160x120:rate=30:duration=2.03");
  const std::vector<Case> cases = {
      {"regular.mp4", picture + kH264, Regular(0, 30, 61), 1e-9},
      {"offset.mp4", picture + "-vf setpts=PTS+5/TB " + kH264, Regular(5, 30, 61), 1e-9},
      {"offset.mkv", picture + "-vf setpts=PTS+5/TB " + kH264, Regular(5, 30, 61), 0.00051},
      {"variable.mp4", picture + vfr + kH264, variable, 1e-9},
      {"variable.mkv", picture + vfr + kH264, variable, 0.00051},
      {"ntsc.mov", TestPicture("size=160x120:rate=30000/1001:duration=1") + kH264, Regular(0, 30000.0 / 1001, 30),
       1e-9},
      {"fast.mp4", TestPicture("size=160x120:rate=240:duration=0.5") + kH264, Regular(0, 240, 120), 1e-9},
      {"motion_jpeg.avi", picture + "-c:v mjpeg", Regular(0, 30, 61), 1e-9},
      // MPEG-TS begins where its muxer's delay (1.4 s) and the two frames of reordering put it.
      {"stream.ts", picture + kH264, Regular(1.4 + 2.0 / 30, 30, 61), 1.2e-5},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    Ffmpeg(c.arguments + " " + Quote(folder / c.name));
    const Recording recording = ReadAll(folder / c.name);
    // FFmpeg 7 writes a film that begins later than 0 so that its last picture is not shown, by players neither.
    std::vector<double> shown = c.stamps;
    shown.resize(ProbeStamps(folder / c.name).size());
    EXPECT_GE(shown.size() + 1, c.stamps.size());
    EXPECT_THAT(recording.Stamps(), Pointwise(DoubleNear(c.rounding_s), shown));
    EXPECT_EQ(recording.info.irregular_stamps, c.name.starts_with("variable"));
    EXPECT_EQ(recording.info.repaired_stamps, 0);
    if (c.name.starts_with("variable")) {
      EXPECT_NEAR(recording.info.shortest_interval_s, 1.0 / 30, 0.0011);
      EXPECT_NEAR(recording.info.longest_interval_s, 7.0 / 30, 0.0011);
    }
  }
}

TEST(VideoReader, ShowsOfTrimmedFilesWhatPlayersShow) {
  const TemporaryFolder folder;
  const auto source = folder / "source.mp4", open_groups = folder / "open_groups.mp4";
  Ffmpeg(TestPicture("size=160x120:rate=30:duration=3") + kH264 + Quote(source));
  Ffmpeg(TestPicture("size=160x120:rate=30:duration=3") + kH264 + "-x264-params open-gop=1:keyint=20:bframes=3 " +
         Quote(open_groups));
  int made = 0;
  for (const auto& input : {source, open_groups})
    for (const char* start_s : {"0.5", "0.51", "1.01", "1.7"})
      for (const char* extension : {"mp4", "mkv"})
        for (const bool seek_input : {true, false}) {
          const auto trimmed = folder / fmt::format("trimmed{}.{}", made++, extension);
          Ffmpeg(seek_input ? fmt::format("-ss {} -i {} -c copy {}", start_s, Quote(input), Quote(trimmed))
                            : fmt::format("-i {} -ss {} -c copy {}", Quote(input), start_s, Quote(trimmed)));
          SCOPED_TRACE(trimmed);
          const Recording recording = ReadAll(trimmed);
          EXPECT_THAT(recording.Stamps(), Pointwise(DoubleNear(1e-6), ProbeStamps(trimmed)));
          EXPECT_GT(recording.frames.size(), 20u);
          EXPECT_GE(recording.info.frames.value_or(1000), std::ssize(recording.frames));
        }
  const auto end = folder / "end.mp4";
  Ffmpeg(fmt::format("-i {} -t 1.03 -c copy {}", Quote(source), Quote(end)));
  EXPECT_THAT(ReadAll(end).Stamps(), Pointwise(DoubleNear(1e-6), ProbeStamps(end)));
}

TEST(VideoReader, PutsFramesWithoutAStampAfterTheOnesBefore) {
  const TemporaryFolder folder;
  for (const char* name : {"h264.avi", "mpeg2.mpg"}) {
    SCOPED_TRACE(name);
    const std::string codec = std::string(name).ends_with("avi") ? kH264 : "-c:v mpeg2video -bf 2 ";
    Ffmpeg(TestPicture() + codec + Quote(folder / name));
    const Recording recording = ReadAll(folder / name);
    ASSERT_THAT(recording.frames, SizeIs(60));
    EXPECT_GT(recording.info.repaired_stamps, 0);
    EXPECT_LE(recording.info.repaired_stamps, 3);  // those held back for reordering at the end
    EXPECT_FALSE(recording.info.irregular_stamps);
    EXPECT_THAT(recording.Stamps(), Pointwise(DoubleNear(1e-4), Regular(recording.frames[0].time_s, 30, 60)));
  }
}

TEST(VideoReader, RefusesAStreamWithoutTimeUnlessTheRateIsGiven) {
  const TemporaryFolder folder;
  const std::pair<const char*, std::string> streams[] = {{"raw.h264", kH264},
                                                         {"raw.obu", "-c:v libaom-av1 -cpu-used 8 -f obu "}};
  for (const auto& [name, codec] : streams) {  // libav makes up 25 Hz for the second
    SCOPED_TRACE(name);
    const auto video = folder / name;
    Ffmpeg(TestPicture("size=64x48:rate=30:duration=0.5") + codec + Quote(video));
    EXPECT_THAT(ErrorOf(video),
                AllOf(HasSubstr(name), HasSubstr("this kind of file has no times"), HasSubstr("--capture-rate")));
    EXPECT_FALSE(video::HasTimes(video));
    EXPECT_EQ(video::StampsInContainer(video), std::nullopt);
    EXPECT_THAT(ReadAll(video, {.capture_rate_hz = 60}).Stamps(), Pointwise(DoubleNear(1e-12), Regular(0, 60, 15)));
  }
}

TEST(VideoReader, CaptureRateCountsFromTheFirstStamp) {
  const TemporaryFolder folder;
  const auto video = folder / "slow.mp4";
  Ffmpeg(TestPicture() + "-vf setpts=PTS+2/TB " + kH264 + Quote(video));
  EXPECT_THAT(ReadAll(video, {.capture_rate_hz = 240}).Stamps(), Pointwise(DoubleNear(1e-12), Regular(2, 240, 60)));
  const Recording part = ReadAll(video, {.capture_rate_hz = 240, .first = 24, .last = 30});
  EXPECT_THAT(part.Stamps(), Pointwise(DoubleNear(1e-12), Regular(2 + 24 / 240.0, 240, 7)));
}

TEST(VideoReader, HandsOutTheAskedSeconds) {
  const TemporaryFolder folder;
  const auto video = folder / "late.mp4";
  Ffmpeg(TestPicture() + "-vf setpts=PTS+2/TB " + kH264 + Quote(video));
  const std::vector<double> stamps = ReadAll(video).Stamps();
  // Both ends count, whatever is lost when a time is typed.
  const Recording part = ReadAll(video, {.start_s = stamps[17] + 4e-7, .end_s = stamps[23] - 4e-7});
  ASSERT_THAT(part.frames, SizeIs(7));
  EXPECT_EQ(part.frames.front().index, 17);
  EXPECT_EQ(part.frames.front().time_s, stamps[17]);
  EXPECT_THAT(ReadAll(video, {.end_s = stamps[9] + 1e-3}).frames, SizeIs(10));
  EXPECT_THAT(ReadAll(video, {.start_s = stamps[59] - 1e-3}).frames, SizeIs(1));
  // Of a slow-motion file, seconds of the motion.
  EXPECT_THAT(ReadAll(video, {.capture_rate_hz = 240, .start_s = 2 + 24 / 240.0, .end_s = 2 + 30 / 240.0}).frames,
              SizeIs(7));
  EXPECT_THAT(ErrorOf(video, {.start_s = 90}), HasSubstr("s; 90 s was asked for"));
  EXPECT_THAT(ErrorOf(video, {.end_s = 1.5}), HasSubstr("no frame lies between 0 and 1.5 s; the next is at 2 s"));
  EXPECT_THAT(ErrorOf(video, {.start_s = stamps[3] + 1e-3, .end_s = stamps[4] - 1e-3}), HasSubstr("no frame lies"));
}

TEST(VideoReader, HandsOutTheAskedFrames) {
  const TemporaryFolder folder;
  const auto video = folder / "video.mp4";
  Ffmpeg(TestPicture() + kH264 + Quote(video));
  const Recording all = ReadAll(video), part = ReadAll(video, {.first = 17, .last = 23});
  ASSERT_THAT(part.frames, SizeIs(7));
  for (std::size_t i = 0; i < part.frames.size(); ++i) {
    EXPECT_EQ(part.frames[i].index, static_cast<std::int64_t>(17 + i));
    EXPECT_EQ(part.frames[i].time_s, all.frames[17 + i].time_s);
    EXPECT_EQ(LargestDifference(part.frames[i].luma, all.frames[17 + i].luma), 0);
  }
  EXPECT_THAT(ReadAll(video, {.first = 59, .last = 1000}).frames, SizeIs(1));
  EXPECT_THAT(ErrorOf(video, {.first = 60}), HasSubstr("has 60 frames, from 0; frame 60 was asked for"));
}

TEST(VideoReader, FramesOutliveTheReader) {
  const TemporaryFolder folder;
  const auto video = folder / "video.mp4";
  Ffmpeg(TestPicture() + kH264 + Quote(video));
  const Recording held = ReadAll(video);  // all 60 frames at once; the reader is gone
  const auto raw = RawLuma(video);
  for (std::size_t i = 0; i < held.frames.size(); ++i)
    ASSERT_EQ(LargestDifference(held.frames[i].luma, RawFrame(raw, i, {320, 240}, CV_8UC1)), 0);
}

TEST(VideoReader, SharesTheDecodersMemory) {
  const TemporaryFolder folder;
  const auto video = folder / "video.mp4";
  Ffmpeg(TestPicture() + kH264 + Quote(video));
  const auto reader = video::VideoReader::Open(video);
  video::VideoFrame frame;
  ASSERT_TRUE(reader->Read(frame));
  EXPECT_EQ(frame.luma.u, nullptr);  // OpenCV does not own it: nothing was copied
  EXPECT_NE(frame.keep_alive, nullptr);
  EXPECT_TRUE(frame.bgr.empty());
}

TEST(VideoReader, TurnsAsThePlayersDo) {
  const TemporaryFolder folder;
  const auto source = folder / "source.mp4";
  Ffmpeg(TestPicture("size=320x240:rate=30:duration=0.3") + kH264 + Quote(source));
  const std::string upright = ReadTextFile(source);
  // The display matrix of the track header, behind the identity of the movie header: a b u c d v x y w,
  // big-endian 16.16.
  struct Case {
    int a, b, c, d;
    int rotation_deg;
    bool mirrored;
  };
  for (const Case& c : {Case{1, 0, 0, 1, 0, false},
                        {0, 1, -1, 0, 90, false},
                        {-1, 0, 0, -1, 180, false},
                        {0, -1, 1, 0, 270, false},
                        {-1, 0, 0, 1, 0, true},
                        {1, 0, 0, -1, 180, true}}) {
    SCOPED_TRACE(fmt::format("{} {} {} {}", c.a, c.b, c.c, c.d));
    const auto matrix = [](int a, int b, int cc, int d) {
      std::string bytes(36, '\0');
      const auto put = [&](int position, int value) {
        bytes[4 * position] = bytes[4 * position + 1] = value < 0 ? '\xff' : '\0';
        if (value >= 0) bytes[4 * position + 1] = static_cast<char>(value);
      };
      put(0, a);
      put(1, b);
      put(3, cc);
      put(4, d);
      bytes[32] = 0x40;
      return bytes;
    };
    std::string bytes = upright;
    const std::size_t at = bytes.find(matrix(1, 0, 0, 1), bytes.find("tkhd"));
    ASSERT_NE(at, std::string::npos);
    bytes.replace(at, 36, matrix(c.a, c.b, c.c, c.d));
    const auto turned = folder / "turned.mp4";
    WriteTextFile(turned, bytes);
    const Recording recording = ReadAll(turned, {.colour = true});
    EXPECT_EQ(recording.info.rotation_deg, c.rotation_deg);
    EXPECT_EQ(recording.info.mirrored, c.mirrored);
    EXPECT_EQ(recording.info.width, c.a ? 320 : 240);
    EXPECT_EQ(recording.frames.front().bgr.size(), cv::Size(recording.info.width, recording.info.height));
    ExpectLumaAsStored(turned);
  }
}

TEST(VideoReader, TurnsByMetadataAndRefusesSlantedPictures) {
  const TemporaryFolder folder;
  const auto source = folder / "source.mp4";
  Ffmpeg(TestPicture("size=320x240:rate=30:duration=0.3") + kH264 + Quote(source));
  for (const int angle : {90, 180, 270}) {
    const auto turned = folder / fmt::format("turned{}.mp4", angle);
    TurnFilm(source, angle, turned);
    ExpectLumaAsStored(turned);
  }
  const auto slanted = folder / "slanted.mp4";
  TurnFilm(source, 45, slanted);
  EXPECT_THAT(ErrorOf(slanted), HasSubstr("turned by an angle that is no multiple of 90°"));
}

// One colour, encoded with either matrix and range, must come back as that colour: rounding to 8-bit YUV loses up
// to 1.5 levels, the quick conversion 1.5 more.
TEST(VideoReader, ConvertsColourByMatrixAndRange) {
  const TemporaryFolder folder;
  for (const char* tags :
       {"-vf scale=out_color_matrix=bt709:out_range=tv -colorspace bt709 -color_range tv",
        "-vf scale=out_color_matrix=bt601:out_range=tv -colorspace smpte170m -color_range tv",
        "-vf scale=out_color_matrix=bt709:out_range=pc -colorspace bt709 -color_range pc",
        "-vf scale=out_color_matrix=bt601:out_range=tv", "-vf scale=1280:720:out_color_matrix=bt709:out_range=tv"}) {
    SCOPED_TRACE(tags);
    const auto video = folder / "colour.mp4";
    Ffmpeg(fmt::format(
        "-f lavfi -i color=0xC86432:size=322x242:rate=30:duration=0.1 {} -pix_fmt yuv420p -c:v libx264 -qp 4 {}", tags,
        Quote(video)));
    const Recording recording = ReadAll(video, {.colour = true});
    const cv::Mat expected(recording.frames[0].bgr.size(), CV_8UC3, cv::Scalar(0x32, 0x64, 0xC8));
    EXPECT_LE(LargestDifference(recording.frames[0].bgr, expected), 3);
  }
}

TEST(VideoReader, ConvertsColourAtAnySize) {
  const TemporaryFolder folder;
  for (const int width : {2, 34, 322, 336, 842, 848, 1080, 1278, 1280}) {
    SCOPED_TRACE(width);
    const int height = width > 1000 ? 720 : 242;
    const auto video = folder / fmt::format("{}.mkv", width);
    Ffmpeg(fmt::format("-f lavfi -i gradients=size={}x{}:rate=30:duration=0.04:seed=1 -c:v ffv1 -pix_fmt yuv420p {}",
                       width, height, Quote(video)));
    const Recording recording = ReadAll(video, {.colour = true});
    const auto raw = RawFrames(video, "bgr24",
                               fmt::format("scale=in_color_matrix={}:flags=bilinear+accurate_rnd+full_chroma_int",
                                           height > 576 ? "bt709" : "bt601"));
    const cv::Mat& bgr = recording.frames[0].bgr;
    const cv::Mat expected = RawFrame(raw, 0, bgr.size(), CV_8UC3);
    // Widths of whole 16 are converted quickly, without interpolating chroma; these colours change slowly.
    const bool exact = width % 16 != 0;
    EXPECT_LE(LargestDifference(bgr, expected), exact ? 0 : 8);
    EXPECT_LE(cv::norm(bgr, expected, cv::NORM_L1) / static_cast<double>(3 * bgr.total()), 2.0);
  }
}

// Raw AVI stores the lowest line first.
TEST(VideoReader, TurnsPicturesThatAreStoredBottomUp) {
  const TemporaryFolder folder;
  const auto video = folder / "raw.avi";
  Ffmpeg(TestPicture("size=66x50:rate=30:duration=0.1") + "-c:v rawvideo -pix_fmt bgr24 " + Quote(video));
  const Recording recording = ReadAll(video, {.colour = true});
  const auto raw = RawFrames(video, "bgr24");
  ASSERT_EQ(recording.frames.size(), 3u);
  for (std::size_t i = 0; i < recording.frames.size(); ++i)
    EXPECT_EQ(LargestDifference(recording.frames[i].bgr, RawFrame(raw, i, {66, 50}, CV_8UC3)), 0) << i;
}

TEST(VideoReader, ReadsRealRecordings) {
  const std::filesystem::path data = SharedData();
  if (!std::filesystem::exists(data)) GTEST_SKIP() << data << " is not there";
  const auto walk = data / "led_leg_walk/mocap1_Chang2.mp4",
             toss = data / "tracker_balltoss/videos/BallToss_new_BallToss.mp4";
  const Recording a = ReadAll(walk), b = ReadAll(toss);
  EXPECT_THAT(a.frames, SizeIs(74));
  EXPECT_EQ(cv::Size(a.info.width, a.info.height), cv::Size(840, 630));
  EXPECT_THAT(a.Stamps(), Pointwise(DoubleNear(1e-9), Regular(1.0 / 30, 30, 74)));
  EXPECT_THAT(b.frames, SizeIs(13));
  EXPECT_THAT(b.Stamps(), Pointwise(DoubleNear(1e-6), ProbeStamps(toss)));
  ExpectLumaAsStored(walk);
  ExpectLumaAsStored(toss);
}

TEST(VideoReader, TellsWhatMatters) {
  const TemporaryFolder folder;
  const auto wide = folder / "wide.mp4", fields = folder / "fields.mp4";
  Ffmpeg(TestPicture("size=320x240:rate=50:duration=0.3") + "-vf setsar=16/11 " + kH264 + Quote(wide));
  Ffmpeg(TestPicture("size=320x240:rate=50:duration=0.3") + "-vf interlace -flags +ilme+ildct " + kH264 +
         Quote(fields));
  const video::VideoInfo info = ReadAll(wide).info;
  EXPECT_NEAR(info.pixel_aspect, 16.0 / 11, 1e-12);
  EXPECT_NEAR(info.frame_rate_hz, 50, 1e-9);
  EXPECT_EQ(info.codec, "h264");
  EXPECT_EQ(info.pixel_format, "yuv420p");
  EXPECT_EQ(info.frames, 15);
  EXPECT_FALSE(info.interlaced);
  EXPECT_TRUE(ReadAll(fields).info.interlaced);
}

// 0 if the interrupt ended the reading, and all that it held is gone.
int ReadUntilInterrupted() {
  const TemporaryFolder folder;
  const auto video = folder / "video.mp4";
  Ffmpeg(TestPicture() + kH264 + Quote(video));
  CatchInterrupts();
  try {
    const auto reader = video::VideoReader::Open(video);
    video::VideoFrame frame;
    reader->Read(frame);
    std::raise(SIGINT);
    reader->Read(frame);
  } catch (const Interrupted& interrupted) {
    return interrupted.Signal() == SIGINT ? 0 : 2;
  }
  return 1;
}

TEST(VideoReaderDeathTest, EndsCleanlyWhenInterrupted) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(std::_Exit(ReadUntilInterrupted()), ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace lake::test
