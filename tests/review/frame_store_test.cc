// Frame n is frame n, whatever was shown before.
#include "lake/review/frame_store.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <thread>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/video/image.h"
#include "lake/video/video_writer.h"
#include "temporary_folder.h"

namespace lake::review {
namespace {

constexpr int kBits = 9, kSide = 16, kFrames = 420;  // longer than the distance of key frames

// The number of a frame as bright and dark fields.
cv::Mat Coded(int number) {
  cv::Mat picture(32, kBits * kSide, CV_8UC1, cv::Scalar(20));
  for (int bit = 0; bit < kBits; ++bit)
    if (number >> bit & 1) cv::rectangle(picture, {bit * kSide, 0, kSide, 32}, cv::Scalar(230), cv::FILLED);
  return picture;
}

int Decoded(const cv::Mat& picture) {
  int number = 0;
  for (int bit = 0; bit < kBits; ++bit) number |= (picture.at<std::uint8_t>(16, bit * kSide + kSide / 2) > 128) << bit;
  return number;
}

class Frames : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    video::VideoWriter writer(Video(), {.width = kBits * kSide, .height = 32, .grey = true});
    // Irregular stamps, beginning late: numbers cannot be told from times by a rate.
    for (int i = 0; i < kFrames; ++i) writer.Write(Coded(i), 0.5 + i / 30.0 + (i % 3 == 0 ? 0.004 : 0));
    writer.Finish();
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::filesystem::path Video() { return *folder_ / "coded.mp4"; }

  static void Expect(FrameStore& store, int frame) {
    const StoredFrame stored = store.Frame(frame);
    EXPECT_EQ(Decoded(stored.luma), frame);
    const std::filesystem::path jpeg = *folder_ / "frame.jpg";
    WriteTextFile(jpeg, *stored.jpeg);
    EXPECT_EQ(Decoded(video::ReadImage(jpeg, false)), frame);
  }

  static inline std::unique_ptr<TemporaryFolder> folder_;
};

TEST_F(Frames, AreExactInAnyOrder) {
  FrameStore store(Video(), {});
  for (const int frame : {0, 1, 2, 419, 418, 417, 250, 249, 251, 3, 400, 0, 300, 299, 298, 419}) Expect(store, frame);
}

TEST_F(Frames, AreExactBackwards) {
  FrameStore store(Video(), {}, {.most_bytes = 100'000, .behind = 3});
  for (int frame = 419; frame > 380; --frame) Expect(store, frame);
}

TEST_F(Frames, AreOfOneVideoForSeveralWhoAsk) {
  FrameStore store(Video(), {});
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t)
    threads.emplace_back([&store, t] {
      for (int i = 0; i < 8; ++i) {
        const int frame = (i * 97 + t * 131) % kFrames;
        EXPECT_EQ(Decoded(store.Frame(frame).luma), frame);
      }
    });
  for (std::thread& thread : threads) thread.join();
}

TEST_F(Frames, TakeBoundedMemory) {
  constexpr std::size_t kMost = 60'000;
  FrameStore store(Video(), {}, {.most_bytes = kMost});
  for (int frame = 0; frame < kFrames; ++frame) {
    store.Frame(frame);
    ASSERT_LE(store.BytesKept(), kMost);
  }
  Expect(store, 10);
}

TEST_F(Frames, ThatAreNotThereAreErrors) {
  FrameStore store(Video(), {});
  Expect(store, kFrames - 1);
  for (const std::int64_t frame :
       {std::int64_t{kFrames}, std::int64_t{1} << 60, std::numeric_limits<std::int64_t>::max(), std::int64_t{-1}}) {
    EXPECT_THROW(store.Frame(frame), Error) << frame;
  }
  Expect(store, kFrames - 1);
}

TEST(FrameSequence, GoesBackToo) {
  const TemporaryFolder folder;
  for (int i = 0; i < 6; ++i) video::WriteImage(folder / fmt::format("{:03}.png", i + 4), Coded(i));
  video::VideoReaderOptions reader;
  reader.capture_rate_hz = 60;
  FrameStore store(folder / "%03d.png", reader);
  for (const int frame : {5, 0, 3}) EXPECT_EQ(Decoded(store.Frame(frame).luma), frame);
}

}  // namespace
}  // namespace lake::review
