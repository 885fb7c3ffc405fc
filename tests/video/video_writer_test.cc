#include "lake/video/video_writer.h"

#include <gmock/gmock.h>

#include <random>

#include "file_limit.h"
#include "video_files.h"

namespace lake::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// Moving blobs and noise: something for every part of the encoder.
std::vector<cv::Mat> Pictures(int frames, cv::Size size, int type, unsigned seed) {
  cv::RNG random(seed);
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < frames; ++i) {
    cv::Mat picture(size, type);
    random.fill(picture, cv::RNG::UNIFORM, 0, 256);
    picture(cv::Rect(0, 0, size.width / 2, size.height)).setTo(cv::Scalar::all((i * 7) % 256));
    pictures.push_back(picture);
  }
  return pictures;
}

void WriteVideo(const std::filesystem::path& path, const video::VideoWriterOptions& options,
                const std::vector<cv::Mat>& pictures, const std::vector<double>& stamps) {
  video::VideoWriter writer(path, options);
  for (std::size_t i = 0; i < pictures.size(); ++i) writer.Write(pictures[i], stamps[i]);
  writer.Finish();
}

std::vector<double> IrregularStamps(std::size_t frames, double start_s, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> interval_s(0.004, 0.21);
  std::vector<double> stamps = {start_s};
  while (stamps.size() < frames) stamps.push_back(stamps.back() + interval_s(random));
  return stamps;
}

TEST(VideoWriter, LosslessGreyComesBackToTheBit) {
  const TemporaryFolder folder;
  unsigned seed = 1;
  for (const cv::Size size : {cv::Size(320, 240), cv::Size(322, 246), cv::Size(1282, 722), cv::Size(2, 2)}) {
    const auto pictures = Pictures(20, size, CV_8UC1, seed);
    const auto stamps = IrregularStamps(20, 0.7, seed++);
    const auto video = folder / "grey.mp4";
    WriteVideo(video, {.width = size.width, .height = size.height, .lossless = true, .grey = true}, pictures, stamps);
    const Recording recording = ReadAll(video);
    ASSERT_EQ(recording.frames.size(), pictures.size());
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      EXPECT_EQ(LargestDifference(recording.frames[i].luma, pictures[i]), 0);
      EXPECT_NEAR(recording.frames[i].time_s, stamps[i], 0.5 / 90000 + 1e-12);
    }
    EXPECT_EQ(FilesIn(folder), 1);
  }
}

TEST(VideoWriter, PicturesMayBePartsOfOthers) {
  const TemporaryFolder folder;
  const cv::Mat large = Pictures(1, {400, 300}, CV_8UC1, 5).front();
  const cv::Mat part = large(cv::Rect(13, 7, 320, 240));
  WriteVideo(folder / "v.mp4", {.width = 320, .height = 240, .lossless = true, .grey = true}, {part}, {0});
  EXPECT_EQ(LargestDifference(ReadAll(folder / "v.mp4").frames[0].luma, part), 0);
}

// A smooth picture at CRF 17: each level of grey comes back as itself, black and white included, so the range is not
// squeezed.
TEST(VideoWriter, LossyGreyKeepsTheLevels) {
  const TemporaryFolder folder;
  cv::Mat ramp(240, 512, CV_8UC1);
  for (int x = 0; x < ramp.cols; ++x) ramp.col(x).setTo(x / 2);
  WriteVideo(folder / "v.mp4", {.width = 512, .height = 240, .crf = 17, .grey = true}, std::vector<cv::Mat>(10, ramp),
             IrregularStamps(10, 0, 1));
  for (const video::VideoFrame& frame : ReadAll(folder / "v.mp4").frames) {
    EXPECT_LE(LargestDifference(frame.luma, ramp), 3);
    EXPECT_LE(cv::norm(frame.luma, ramp, cv::NORM_L1) / static_cast<double>(ramp.total()), 0.6);
  }
}

TEST(VideoWriter, GreyIsGreyInColourToo) {
  const TemporaryFolder folder;
  const auto pictures = Pictures(3, {320, 240}, CV_8UC1, 2);
  WriteVideo(folder / "v.mp4", {.width = 320, .height = 240, .lossless = true, .grey = true}, pictures, {0, 0.1, 0.2});
  const Recording recording = ReadAll(folder / "v.mp4", {.colour = true});
  cv::Mat channels[3];
  cv::split(recording.frames[1].bgr, channels);
  for (const cv::Mat& channel : channels) EXPECT_LE(LargestDifference(channel, pictures[1]), 1);  // rounding of swscale
}

TEST(VideoWriter, ColoursComeBack) {
  const TemporaryFolder folder;
  for (const cv::Size size : {cv::Size(320, 240), cv::Size(1280, 720)})
    for (const bool lossless : {true, false}) {
      cv::Mat picture(size, CV_8UC3);
      const cv::Scalar colours[] = {{255, 255, 255}, {0, 0, 0},     {50, 100, 200}, {200, 60, 20},
                                    {40, 180, 60},   {0, 159, 230}, {213, 94, 0},   {128, 128, 128}};
      for (int i = 0; i < 8; ++i)
        picture(cv::Rect(i * size.width / 8, 0, size.width / 8, size.height)).setTo(colours[i]);
      WriteVideo(folder / "v.mp4", {.width = size.width, .height = size.height, .crf = 12, .lossless = lossless},
                 {picture, picture}, {0, 0.02});
      const Recording recording = ReadAll(folder / "v.mp4", {.colour = true});
      for (int i = 0; i < 8; ++i) {  // inside each patch; chroma is blurred at its border
        const cv::Rect inside(i * size.width / 8 + 8, 8, size.width / 8 - 16, size.height - 16);
        const cv::Scalar mean = cv::mean(recording.frames[1].bgr(inside));
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], colours[i][c], 3) << "patch " << i;  // limited-range 8-bit YUV
      }
    }
}

TEST(VideoWriter, StampsComeBackExactly) {
  const TemporaryFolder folder;
  for (const double rate_hz : {25.0, 30000.0 / 1001, 60.0, 120.0, 240.0})
    for (const double start_s : {0.0, 1.0 / 3, 1234.5}) {
      const auto pictures = Pictures(40, {64, 48}, CV_8UC1, 4);
      std::vector<double> stamps;
      for (int i = 0; i < 40; ++i) stamps.push_back(start_s + i / rate_hz);
      WriteVideo(folder / "v.mp4", {.width = 64, .height = 48, .frame_rate_hz = rate_hz, .grey = true}, pictures,
                 stamps);
      const Recording recording = ReadAll(folder / "v.mp4");
      EXPECT_THAT(recording.Stamps(), ::testing::Pointwise(::testing::DoubleNear(0.5 / 90000 + 1e-10), stamps));
      EXPECT_THAT(recording.Stamps(), ::testing::Pointwise(::testing::DoubleNear(1e-6), ProbeStamps(folder / "v.mp4")));
      EXPECT_EQ(recording.info.frames, 40);
      EXPECT_FALSE(recording.info.irregular_stamps);
    }
}

TEST(VideoWriter, SlowPresetsReorderWithoutLosingFrames) {
  const TemporaryFolder folder;
  const auto pictures = Pictures(70, {128, 96}, CV_8UC1, 6);
  const auto stamps = IrregularStamps(70, 3, 6);
  for (const char* preset : {"ultrafast", "veryfast", "slow"}) {
    WriteVideo(folder / "v.mp4",
               {.width = 128, .height = 96, .lossless = true, .grey = true, .preset = preset, .threads = 3}, pictures,
               stamps);
    const Recording recording = ReadAll(folder / "v.mp4");
    ASSERT_EQ(recording.frames.size(), 70u);
    for (std::size_t i = 0; i < 70; ++i) ASSERT_EQ(LargestDifference(recording.frames[i].luma, pictures[i]), 0);
  }
}

TEST(VideoWriter, SaysItsRangeAndColoursAndPutsTheIndexFirst) {
  const TemporaryFolder folder;
  const auto probe = [&](const std::filesystem::path& video) {
    Shell(fmt::format(
        "ffprobe -v error -show_entries stream=pix_fmt,color_range,color_space,codec_tag_string -of csv=p=0 {} > {}",
        Quote(video), Quote(folder / "out")));
    return ReadTextFile(folder / "out");
  };
  WriteVideo(folder / "grey.mp4", {.width = 320, .height = 240, .grey = true}, Pictures(2, {320, 240}, CV_8UC1, 1),
             {0, 1});
  EXPECT_THAT(probe(folder / "grey.mp4"),
              AllOf(HasSubstr("avc1"), HasSubstr("yuvj420p"), HasSubstr("pc"), HasSubstr("smpte170m")));
  WriteVideo(folder / "hd.mp4", {.width = 1280, .height = 720}, Pictures(2, {1280, 720}, CV_8UC3, 1), {0, 1});
  EXPECT_THAT(probe(folder / "hd.mp4"), AllOf(HasSubstr("yuv420p"), HasSubstr("tv"), HasSubstr("bt709")));
  const std::string bytes = ReadTextFile(folder / "hd.mp4");
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
}

TEST(VideoWriter, LeavesNothingWhenNotFinished) {
  const TemporaryFolder folder;
  {
    video::VideoWriter writer(folder / "v.mp4", {.width = 320, .height = 240, .grey = true});
    for (const cv::Mat& picture : Pictures(5, {320, 240}, CV_8UC1, 1)) {
      static double time_s = 0;
      writer.Write(picture, time_s += 0.1);
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "v.mp4"));
    EXPECT_EQ(FilesIn(folder), 1);
  }
  EXPECT_EQ(FilesIn(folder), 0);
}

TEST(VideoWriter, RefusesWhatItCannotWrite) {
  const TemporaryFolder folder;
  const auto video = folder / "v.mp4";
  const auto opening = [&](video::VideoWriterOptions options) {
    return [&, options] { video::VideoWriter(video, options); };
  };
  EXPECT_THAT(opening({.width = 321, .height = 240}),
              ThrowsMessage<Error>(HasSubstr("321×240 px cannot be written; both sides must be even")));
  EXPECT_THAT(opening({.width = 0, .height = 0}), ThrowsMessage<Error>(HasSubstr("0×0 px")));
  EXPECT_THAT(opening({.width = 20000, .height = 20}), ThrowsMessage<Error>(HasSubstr("too large")));
  EXPECT_THAT(opening({.width = 32, .height = 32, .crf = 60}), ThrowsMessage<Error>(HasSubstr("CRF 60")));
  EXPECT_THAT(opening({.width = 32, .height = 32, .frame_rate_hz = std::nan("")}),
              ThrowsMessage<Error>(HasSubstr("no frame rate")));
  EXPECT_THAT(opening({.width = 32, .height = 32, .preset = "fastest"}),
              ThrowsMessage<Error>(HasSubstr("x264 has no preset 'fastest'; it has ultrafast")));
  EXPECT_THAT([&] { video::VideoWriter(folder / "nowhere" / "v.mp4", {.width = 32, .height = 32}); },
              ThrowsMessage<Error>(AllOf(HasSubstr("v.mp4: cannot be written"), HasSubstr("No such file"))));

  video::VideoWriter writer(video, {.width = 32, .height = 32});
  const cv::Mat fits(32, 32, CV_8UC3, cv::Scalar::all(0));
  EXPECT_THAT([&] { writer.Write(cv::Mat(32, 32, CV_8UC1), 0); },
              ThrowsMessage<Error>(HasSubstr("does not fit a video")));
  EXPECT_THAT([&] { writer.Write(cv::Mat(30, 32, CV_8UC3), 0); }, ThrowsMessage<Error>(HasSubstr("32×30 px")));
  EXPECT_THAT([&] { writer.Write(fits, -0.1); }, ThrowsMessage<Error>(HasSubstr("-0.1 s cannot be written")));
  EXPECT_THAT([&] { writer.Write(fits, std::nan("")); }, ThrowsMessage<Error>(HasSubstr("cannot be written")));
  EXPECT_THAT([&] { writer.Finish(); }, ThrowsMessage<Error>(HasSubstr("without a frame")));
  writer.Write(fits, 1);
  EXPECT_THAT([&] { writer.Write(fits, 1); }, ThrowsMessage<Error>(HasSubstr("does not come after")));
}

// The file may not grow beyond so many bytes.
TEST(VideoWriter, FullDiskIsAnErrorAndLeavesNothing) {
  const TemporaryFolder folder;
  const auto pictures = Pictures(30, {320, 240}, CV_8UC1, 3);
  const auto stamps = IrregularStamps(30, 0, 3);
  WriteVideo(folder / "v.mp4", {.width = 320, .height = 240, .grey = true}, pictures, stamps);
  const auto whole_bytes = std::filesystem::file_size(folder / "v.mp4");
  std::filesystem::remove(folder / "v.mp4");
  // x264's films of the same pictures differ by up to some thousand bytes, by how busy the machine is.
  for (const auto bytes : {std::uintmax_t{0}, std::uintmax_t{20}, whole_bytes / 2, whole_bytes * 9 / 10}) {
    SCOPED_TRACE(bytes);
    const FileLimit limit(bytes);
    EXPECT_THAT([&] { WriteVideo(folder / "v.mp4", {.width = 320, .height = 240, .grey = true}, pictures, stamps); },
                ThrowsMessage<Error>(AllOf(HasSubstr("v.mp4: cannot be written"), HasSubstr("File too large"))));
    EXPECT_EQ(FilesIn(folder), 0);
  }
}

}  // namespace
}  // namespace lake::test
