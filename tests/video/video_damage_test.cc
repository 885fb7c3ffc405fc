// Files that are not what they should be: every one ends in an error that names the file and the frame, and no picture
// that the decoder made up is handed out.
#include <gmock/gmock.h>

#include <random>

#include "video_files.h"

namespace lake::test {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::SizeIs;

// Reading a damaged copy must fail, and each frame handed out before that must be the whole file's own.
void ExpectHonestFailure(const std::filesystem::path& damaged, const Recording& whole) {
  SCOPED_TRACE(damaged);
  std::vector<video::VideoFrame> frames;
  const std::string error = ErrorOf(damaged, {}, &frames);
  EXPECT_THAT(error, AllOf(HasSubstr(damaged.filename().string()), HasSubstr(fmt::format("frame {} ", frames.size())),
                           Not(HasSubstr("\n"))));
  ASSERT_LT(frames.size(), whole.frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ASSERT_EQ(frames[i].time_s, whole.frames[i].time_s);
    ASSERT_EQ(LargestDifference(frames[i].luma, whole.frames[i].luma), 0) << "frame " << i;
  }
}

// 400 random bytes somewhere in the middle.
std::string Overwrite(std::string bytes, unsigned seed) {
  std::mt19937 random(seed);
  const std::size_t at = bytes.size() / 5 + random() % (bytes.size() * 3 / 5);
  for (std::size_t i = 0; i < 400; ++i) bytes[at + i] = static_cast<char>(random());
  return bytes;
}

TEST(VideoDamage, CutFiles) {
  const TemporaryFolder folder;
  for (const auto& [name, codec] : std::vector<std::pair<std::string, std::string>>{
           {"index_first.mp4", std::string(kH264) + "-movflags +faststart"},
           {"fragmented.mp4", std::string(kH264) + "-movflags frag_keyframe+empty_moov"},
           {"h264.mkv", kH264},
           {"vp9.webm", "-c:v libvpx-vp9 -deadline realtime -cpu-used 8 -b:v 1M"},
           {"motion_jpeg.avi", "-c:v mjpeg -q:v 3"},
           {"mpeg4.avi", "-c:v mpeg4 -bf 2 -q:v 3"}}) {
    Ffmpeg(TestPicture() + codec + " " + Quote(folder / name));
    const Recording whole = ReadAll(folder / name);
    const std::string bytes = ReadTextFile(folder / name);
    for (const double share : {0.35, 0.6, 0.93}) {
      const auto cut = folder / fmt::format("cut_{}_{}", share, name);
      WriteTextFile(cut, bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
      ExpectHonestFailure(cut, whole);
    }
  }
}

// A transport stream does not say how long it is. If the cut is noticed, it is an error; if not, only whole frames
// come.
TEST(VideoDamage, CutTransportStream) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture() + kH264 + Quote(folder / "v.ts"));
  const Recording whole = ReadAll(folder / "v.ts");
  const std::string bytes = ReadTextFile(folder / "v.ts");
  for (int percent = 30; percent < 100; percent += 4) {
    SCOPED_TRACE(percent);
    WriteTextFile(folder / "cut.ts", bytes.substr(0, bytes.size() * percent / 100));
    std::vector<video::VideoFrame> frames;
    ErrorOf(folder / "cut.ts", {}, &frames);
    EXPECT_GT(frames.size(), whole.frames.size() * percent / 100 / 2);
    for (const video::VideoFrame& frame : frames) {
      const auto original = std::find_if(whole.frames.begin(), whole.frames.end(),
                                         [&](const video::VideoFrame& w) { return w.time_s == frame.time_s; });
      ASSERT_NE(original, whole.frames.end());
      ASSERT_EQ(LargestDifference(frame.luma, original->luma), 0) << frame.time_s;
    }
  }
}

TEST(VideoDamage, CutFileWithItsIndexAtTheEnd) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture() + kH264 + Quote(folder / "whole.mp4"));
  const std::string bytes = ReadTextFile(folder / "whole.mp4");
  WriteTextFile(folder / "cut.mp4", bytes.substr(0, bytes.size() / 2));
  EXPECT_THAT(ErrorOf(folder / "cut.mp4"),
              AllOf(HasSubstr("cut.mp4: "), HasSubstr("damaged at its beginning or index")));
}

// Arithmetic-coded garbage may by chance be legal to its end: libav's own log stays silent on one damaged spot of eight
// (3 of 24 measured with other seeds). Where it is noticed, no picture that the damage touches is handed out.
TEST(VideoDamage, OverwrittenBytesInH264) {
  const TemporaryFolder folder;
  int noticed = 0, damaged = 0;
  for (const char* name : {"h264.mp4", "h264.mkv"}) {
    Ffmpeg(TestPicture("size=640x360:rate=30:duration=2,noise=alls=12:allf=t") + kH264 + "-movflags +faststart " +
           Quote(folder / name));
    const Recording whole = ReadAll(folder / name);
    const std::string bytes = ReadTextFile(folder / name);
    for (unsigned seed = 0; seed < 7; ++seed, ++damaged) {
      const auto file = folder / fmt::format("damaged{}_{}", seed, name);
      WriteTextFile(file, Overwrite(bytes, seed));
      if (ErrorOf(file).empty()) continue;
      ++noticed;
      ExpectHonestFailure(file, whole);
    }
  }
  EXPECT_GE(noticed, damaged * 7 / 10);
}

// libav's HEVC decoder takes most garbage for a legal slice (14 of 16 files that were tried), and passes over what it
// finds unless it is told not to. Where the encoder wrote each picture's hash, hardly anything escapes.
TEST(VideoDamage, OverwrittenBytesInHevcWithPictureHashes) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=320x180:rate=30:duration=1,noise=alls=12:allf=t") +
         "-c:v libx265 -preset ultrafast -x265-params log-level=none:keyint=20:bframes=3:hash=1 -crf 24 "
         "-pix_fmt yuv420p -movflags +faststart " +
         Quote(folder / "v.mp4"));
  const Recording whole = ReadAll(folder / "v.mp4");
  const std::string bytes = ReadTextFile(folder / "v.mp4");
  constexpr unsigned kFiles = 6;
  unsigned noticed = 0;
  for (unsigned seed = 0; seed < kFiles; ++seed) {
    const auto file = folder / fmt::format("damaged{}.mp4", seed);
    WriteTextFile(file, Overwrite(bytes, seed));
    if (ErrorOf(file).empty()) continue;
    ++noticed;
    ExpectHonestFailure(file, whole);
  }
  EXPECT_GE(noticed, kFiles - 1);
}

TEST(VideoDamage, OverwrittenBytesInMpeg4) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=640x360:rate=30:duration=1,noise=alls=12:allf=t") + "-c:v mpeg4 -bf 2 -q:v 4 " +
         Quote(folder / "m.avi"));
  const Recording whole = ReadAll(folder / "m.avi");
  const std::string bytes = ReadTextFile(folder / "m.avi");
  for (unsigned seed = 0; seed < 5; ++seed) {
    const auto damaged = folder / fmt::format("damaged{}.avi", seed);
    WriteTextFile(damaged, Overwrite(bytes, seed));
    ExpectHonestFailure(damaged, whole);
  }
}

TEST(VideoDamage, TheMessageIsTheSameEveryTime) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=640x360:rate=30:duration=1") + kH264 + "-movflags +faststart " + Quote(folder / "v.mp4"));
  std::string bytes = ReadTextFile(folder / "v.mp4");
  std::mt19937 random(3);
  for (std::size_t i = 0; i < 300; ++i) bytes[bytes.size() / 2 + i] = static_cast<char>(random());
  WriteTextFile(folder / "damaged.mp4", bytes);
  const std::string first = ErrorOf(folder / "damaged.mp4");
  EXPECT_NE(first, "");
  for (int run = 0; run < 20; ++run) EXPECT_EQ(ErrorOf(folder / "damaged.mp4"), first);
}

TEST(VideoDamage, DamagedPictureOfASequence) {
  const TemporaryFolder folder;
  for (const char* extension : {"png", "jpg"}) {
    const auto pattern = folder / fmt::format("%03d.{}", extension);
    Ffmpeg(TestPicture("size=320x240:rate=30:duration=0.3") + Quote(pattern));
    const auto victim = folder / fmt::format("005.{}", extension);
    const std::string bytes = ReadTextFile(victim);
    WriteTextFile(victim, bytes.substr(0, bytes.size() / 2));
    std::vector<video::VideoFrame> frames;
    video::VideoReaderOptions reader;
    reader.capture_rate_hz = 30;
    EXPECT_THAT(ErrorOf(pattern, reader, &frames), HasSubstr(fmt::format("005.{}", extension)));
    EXPECT_THAT(frames, SizeIs(4));
  }
}

TEST(VideoDamage, NotAVideo) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "text.mp4", "frame,time_s\n0,0\n");
  WriteTextFile(folder / "long_text.mp4", std::string(200000, 'x'));
  WriteTextFile(folder / "playlist.mp4", "#EXTM3U\n#EXTINF:1,\nhttp://localhost/x.ts\n");
  WriteTextFile(folder / "list.mp4", "ffconcat version 1.0\nfile other.mp4\n");
  WriteTextFile(folder / "empty.mp4", "");
  Ffmpeg(fmt::format("-f lavfi -i sine=duration=1 {}", Quote(folder / "audio.mp4")));
  Ffmpeg(
      "-f lavfi -i sine=duration=1 -f lavfi -i color=size=64x64:duration=0.04 -map 0 -map 1 -c:v png -disposition:v "
      "attached_pic " +
      Quote(folder / "cover.m4a"));
  EXPECT_THAT(ErrorOf(folder / "absent.mp4"), EndsWith("absent.mp4: no such file"));
  EXPECT_THAT(ErrorOf(folder / ""), HasSubstr("is a folder, not a video"));
  EXPECT_THAT(ErrorOf(folder / "empty.mp4"), EndsWith("empty.mp4: is empty"));
  for (const char* name : {"text.mp4", "long_text.mp4", "playlist.mp4", "list.mp4"})
    EXPECT_THAT(ErrorOf(folder / name), HasSubstr(fmt::format("{}: not a video that can be read", name)));
  EXPECT_THAT(ErrorOf(folder / "audio.mp4"), EndsWith("audio.mp4: holds no video stream that can be decoded"));
  EXPECT_THAT(ErrorOf(folder / "cover.m4a"), EndsWith("cover.m4a: holds a cover picture but no video"));
}

TEST(VideoDamage, NoFrame) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture() + kH264 + "-frames:v 0 " + Quote(folder / "none.mkv"));
  EXPECT_THAT(ErrorOf(folder / "none.mkv"), HasSubstr("none.mkv: "));
}

TEST(VideoDamage, SizeChangesInMidStream) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=320x240:rate=30:duration=0.5") + kH264 + Quote(folder / "a.h264"));
  Ffmpeg(TestPicture("size=160x120:rate=30:duration=0.5") + kH264 + Quote(folder / "b.h264"));
  WriteTextFile(folder / "both.h264",
                fmt::format("{}{}", ReadTextFile(folder / "a.h264"), ReadTextFile(folder / "b.h264")));
  EXPECT_THAT(ErrorOf(folder / "both.h264", {.capture_rate_hz = 30}),
              HasSubstr("both.h264: frame 15 is stored with 160×120 px, those before with 320×240 px"));
}

TEST(VideoDamage, PixelFormatChangesInMidStream) {
  const TemporaryFolder folder;
  std::string both;
  for (const char* format : {"yuv420p", "yuv444p"}) {
    const auto part = folder / fmt::format("{}.h264", format);
    Ffmpeg(TestPicture("size=64x48:rate=30:duration=0.1") + "-c:v libx264 -preset ultrafast -pix_fmt " + format + " " +
           Quote(part));
    both += ReadTextFile(part);
  }
  WriteTextFile(folder / "both.h264", both);
  EXPECT_THAT(ErrorOf(folder / "both.h264", {.capture_rate_hz = 30}),
              HasSubstr("frame 3 has pixel format yuv444p, those before yuv420p; cut the recording there"));
}

TEST(VideoDamage, StampsThatStepBack) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=160x120:rate=30:duration=0.5") + "-c:v mpeg2video -bf 0 " + Quote(folder / "a.mpg"));
  WriteTextFile(folder / "twice.mpg",
                fmt::format("{}{}", ReadTextFile(folder / "a.mpg"), ReadTextFile(folder / "a.mpg")));
  EXPECT_THAT(ErrorOf(folder / "twice.mpg"),
              AllOf(HasSubstr("twice.mpg: frame 15 has time stamp"), HasSubstr("not after the frame before")));
}

// Any bytes at all: an error or a video, never a crash.
TEST(VideoDamage, RandomChangesNeverCrash) {
  const TemporaryFolder folder;
  for (const char* name : {"v.mp4", "v.mkv", "v.avi", "v.png", "v.jpg", "v.tif", "v.bmp"}) {
    const bool picture = std::string("png jpg tif bmp").find(std::string(name).substr(2)) != std::string::npos;
    Ffmpeg(TestPicture("size=96x64:rate=30:duration=0.3") + (picture ? "-frames:v 1 -update 1 " : "") +
           Quote(folder / name));
    const std::string bytes = ReadTextFile(folder / name);
    for (unsigned seed = 0; seed < 60; ++seed) {
      std::mt19937 random(seed);
      std::string changed = bytes;
      for (unsigned i = 0; i < 1 + seed % 20; ++i) changed[random() % changed.size()] = static_cast<char>(random());
      const auto damaged = folder / fmt::format("x_{}", name);
      WriteTextFile(damaged, changed);
      EXPECT_THAT(ErrorOf(damaged, {.colour = true}), Not(HasSubstr("\n")));
    }
  }
}

}  // namespace
}  // namespace lake::test
