#include "lake/video/image.h"

#include <gmock/gmock.h>

#include <boost/crc.hpp>

#include "video_files.h"

namespace lake::test {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

cv::Mat Random(cv::Size size, int type, std::uint64_t seed) {
  cv::Mat picture(size, type);
  cv::RNG(seed).fill(picture, cv::RNG::UNIFORM, 0, 256);
  return picture;
}

cv::Mat AllLevels() {
  cv::Mat levels(16, 256, CV_8UC1);
  for (int x = 0; x < 256; ++x) levels.col(x).setTo(x);
  return levels;
}

TEST(Image, PngComesBackToTheBit) {
  const TemporaryFolder folder;
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(3, 5), cv::Size(131, 77), cv::Size(640, 480)}) {
    const cv::Mat grey = Random(size, CV_8UC1, 1), bgr = Random(size, CV_8UC3, 2);
    video::WriteImage(folder / "grey.png", grey);
    video::WriteImage(folder / "bgr.png", bgr);
    EXPECT_EQ(LargestDifference(video::ReadImage(folder / "grey.png", false), grey), 0);
    EXPECT_EQ(LargestDifference(video::ReadImage(folder / "bgr.png", true), bgr), 0);
  }
  EXPECT_EQ(FilesIn(folder), 2);
}

TEST(Image, GreyIsTheSameThroughEveryPixelFormat) {
  const TemporaryFolder folder;
  const cv::Mat levels = AllLevels();
  video::WriteImage(folder / "grey.png", levels);
  for (const auto& [format, extension] : std::vector<std::pair<std::string, std::string>>{{"rgb24", "png"},
                                                                                          {"rgba", "png"},
                                                                                          {"ya8", "png"},
                                                                                          {"gray16be", "png"},
                                                                                          {"rgb48be", "png"},
                                                                                          {"pal8", "png"},
                                                                                          {"bgr24", "bmp"},
                                                                                          {"gray", "bmp"},
                                                                                          {"gray", "tif"},
                                                                                          {"rgb24", "tif"},
                                                                                          {"gray16le", "tif"},
                                                                                          {"gray", "pgm"}}) {
    SCOPED_TRACE(fmt::format("{} {}", format, extension));
    const auto picture = folder / fmt::format("picture.{}", extension);
    const std::string filter =
        format == "pal8"
            ? "-vf \"format=rgb24,split[a][b];[a]palettegen=reserve_transparent=0[p];[b][p]paletteuse=dither=none\" "
            : "";
    Ffmpeg(fmt::format("-i {} {}-pix_fmt {} {}", Quote(folder / "grey.png"), filter, format, Quote(picture)));
    // 16 bits and a palette may round by one level.
    const double tolerance =
        format.find("16") != std::string::npos || format.find("48") != std::string::npos || format == "pal8" ? 1 : 0;
    EXPECT_LE(LargestDifference(video::ReadImage(picture, false), levels), tolerance);
    cv::Mat bgr;
    cv::merge(std::vector<cv::Mat>(3, levels), bgr);
    EXPECT_LE(LargestDifference(video::ReadImage(picture, true), bgr), tolerance);
  }
}

TEST(Image, GreyOfColoursIsTheUsualMean) {
  const TemporaryFolder folder;
  const cv::Mat bgr = Random({64, 48}, CV_8UC3, 7);
  video::WriteImage(folder / "bgr.png", bgr);
  const cv::Mat grey = video::ReadImage(folder / "bgr.png", false);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const auto& p = bgr.at<cv::Vec3b>(y, x);
      EXPECT_NEAR(grey.at<std::uint8_t>(y, x), 0.114 * p[0] + 0.587 * p[1] + 0.299 * p[2], 0.501);
    }
}

TEST(Image, JpegGivesItsStoredLuma) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=322x242:rate=30:duration=0.04") + "-frames:v 1 -update 1 -q:v 2 " + Quote(folder / "p.jpg"));
  const cv::Mat grey = video::ReadImage(folder / "p.jpg", false);
  EXPECT_EQ(LargestDifference(grey, RawFrame(RawLuma(folder / "p.jpg"), 0, grey.size(), CV_8UC1)), 0);
}

// A JPEG as a phone makes it: the sensor's picture, and a note how to hold it.
TEST(Image, TurnsAsExifSays) {
  const TemporaryFolder folder;
  Ffmpeg(TestPicture("size=320x240:rate=30:duration=0.04") + "-frames:v 1 -update 1 -q:v 2 " +
         Quote(folder / "plain.jpg"));
  const std::string plain = ReadTextFile(folder / "plain.jpg");
  const cv::Mat stored = video::ReadImage(folder / "plain.jpg", false);
  for (int orientation = 1; orientation <= 8; ++orientation) {
    SCOPED_TRACE(orientation);
    std::string exif("Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0?\0\0\0\0\0\0", 32);
    exif[25] = static_cast<char>(orientation);
    std::string jpeg = plain;
    jpeg.insert(2, exif).insert(2, std::string("\xff\xe1\0\x22", 4));  // the segment's length counts itself
    WriteTextFile(folder / "exif.jpg", jpeg);
    cv::Mat expected = stored.clone();  // EXIF 2.3, table of tag 274
    if (orientation >= 5) cv::transpose(stored, expected);
    const bool flip_x = orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7;
    const bool flip_y = orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8;
    if (flip_x) cv::flip(expected.clone(), expected, 1);
    if (flip_y) cv::flip(expected.clone(), expected, 0);
    EXPECT_EQ(LargestDifference(video::ReadImage(folder / "exif.jpg", false), expected), 0);
  }
}

TEST(Image, NamesWithPercentSignsAreNames) {
  const TemporaryFolder folder;
  const cv::Mat grey = Random({20, 10}, CV_8UC1, 3);
  video::WriteImage(folder / "100%d.png", grey);
  EXPECT_EQ(LargestDifference(video::ReadImage(folder / "100%d.png", false), grey), 0);
}

TEST(Image, RefusesWhatIsNoWholePicture) {
  const TemporaryFolder folder;
  const auto reading = [&](const std::string& name) { return [&, name] { video::ReadImage(folder / name, false); }; };
  WriteTextFile(folder / "text.png", "not a picture");
  EXPECT_THAT(reading("text.png"), ThrowsMessage<Error>(HasSubstr("text.png")));
  EXPECT_THAT(reading("absent.png"), ThrowsMessage<Error>(HasSubstr("absent.png: no such file")));
  for (const char* name : {"p.png", "p.jpg", "p.bmp", "p.tif"}) {
    Ffmpeg(TestPicture("size=322x242:rate=30:duration=0.04") + "-frames:v 1 -update 1 " + Quote(folder / name));
    const std::string bytes = ReadTextFile(folder / name);
    for (const double share : {0.02, 0.4, 0.9}) {
      SCOPED_TRACE(fmt::format("{} {}", name, share));
      const std::string cut = fmt::format("cut_{}", name);
      WriteTextFile(folder / cut, bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
      EXPECT_THAT(reading(cut), ThrowsMessage<Error>(HasSubstr(cut)));
    }
  }
}

TEST(Image, RefusesHugePicturesBeforeReadingThem) {
  const TemporaryFolder folder;
  video::WriteImage(folder / "small.png", Random({20, 10}, CV_8UC1, 3));
  const std::string bytes = ReadTextFile(folder / "small.png");
  const auto message = [&](unsigned width, unsigned height) {
    std::string huge = bytes;
    for (unsigned i = 0; i < 4; ++i) {
      huge[16 + i] = static_cast<char>(width >> (24 - 8 * i));
      huge[20 + i] = static_cast<char>(height >> (24 - 8 * i));
    }
    boost::crc_32_type crc;
    crc.process_bytes(huge.data() + 12, 17);  // the header chunk without its length
    for (unsigned i = 0; i < 4; ++i) huge[29 + i] = static_cast<char>(crc.checksum() >> (24 - 8 * i));
    WriteTextFile(folder / "huge.png", huge);
    return ErrorOf(folder / "huge.png");
  };
  EXPECT_THAT(message(20000, 10), HasSubstr("huge.png: 20000×10 px is too large; at most 16384 px a side and 200 Mpx"));
  EXPECT_THAT(message(10, 20000), HasSubstr("huge.png: 10×20000 px is too large"));
  EXPECT_THAT(message(16000, 16000), HasSubstr("larger than 200 Mpx"));
  EXPECT_THAT(message(1u << 30, 1u << 30), HasSubstr("larger than 200 Mpx"));
}

TEST(Image, RefusesToWriteOtherMatrices) {
  const TemporaryFolder folder;
  EXPECT_THAT([&] { video::WriteImage(folder / "x.png", cv::Mat(3, 3, CV_32FC1)); },
              ThrowsMessage<Error>(HasSubstr("CV_32FC1, cannot be written")));
  EXPECT_THAT([&] { video::WriteImage(folder / "x.png", cv::Mat()); }, ThrowsMessage<Error>(HasSubstr("0×0 px")));
  EXPECT_THAT([&] { video::WriteImage("/dev/null/x.png", cv::Mat(3, 3, CV_8UC1)); },
              ThrowsMessage<Error>(HasSubstr("cannot be written")));
  EXPECT_EQ(FilesIn(folder), 0);
}

}  // namespace
}  // namespace lake::test
