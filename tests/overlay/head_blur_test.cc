// Where the head is, of made-up bodies and of a real one; and what a copy leaves as it is.
#include "lake/overlay/head_blur.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "lake/core/error.h"
#include "lake/exchange/trial.h"
#include "lake/video/video_writer.h"
#include "places.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using Eigen::Vector2d;
using testing::HasSubstr;

motion::MarkerRecording Tracks(const std::vector<double>& time_s, const std::vector<std::string>& names) {
  motion::MarkerRecording tracks;
  for (std::size_t i = 0; i < time_s.size(); ++i)
    tracks.frame.push_back(static_cast<std::int64_t>(i)), tracks.time_s.push_back(time_s[i]);
  for (const std::string& name : names)
    tracks.markers.push_back({name, std::vector<motion::MarkerSample>(time_s.size())});
  return tracks;
}

// Someone of 400 px leg who stands in the first half and sits and leans by `lean` in the second; the waist marker is
// turned by `offset` on the pelvis, which turns with the trunk.
motion::MarkerRecording StandThenLean(double lean, double offset, double side) {
  std::vector<double> time_s;
  for (int i = 0; i < 20; ++i) time_s.push_back(0.1 * i);
  motion::MarkerRecording tracks = Tracks(time_s, {"ankle", "knee", "hip", "waist"});
  const Vector2d ankle(300, 700), knee(300, 500);
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    const double turn = side * (offset + (i < 10 ? 0 : lean));
    const Vector2d hip = i < 10 ? Vector2d(300, 300) : Vector2d(100, 500);
    const Vector2d places[] = {ankle, knee, hip, hip + Eigen::Rotation2Dd(turn) * Vector2d(0, -80)};
    for (std::size_t m = 0; m < 4; ++m)
      tracks.markers[m].samples[i] = {places[m], 0.05, motion::SampleStatus::kDetected};
  }
  return tracks;
}

TEST(HeadBlur, FindsTheHeadWhereverTheWaistMarkerSitsOnThePelvis) {
  for (const double side : {1.0, -1.0})
    for (const double offset : {-0.5, 0.0, 0.9}) {
      const overlay::HeadBlur blur(StandThenLean(0.6, offset, side));
      const auto standing = blur.Head(0), leaning = blur.Head(15);
      ASSERT_TRUE(standing && leaning);
      EXPECT_LT((standing->centre - Vector2d(300, 300 - 330)).norm(), 1e-6) << "0.825 of the leg above the hip";
      const Vector2d expected = Vector2d(100, 500) + Eigen::Rotation2Dd(side * 1.25 * 0.6) * Vector2d(0, -330);
      EXPECT_LT((leaning->centre - expected).norm(), 1e-6);
    }
}

// Leaning by 43°, the head is 0.6 of the leg from thigh and waist; by 86° it is 0.3 from the knee.
TEST(HeadBlur, SaysWhereTheLegMayHideTheFace) {
  for (const auto& [lean, done] :
       {std::pair{0.6, overlay::HeadBlur::Done::kHead}, std::pair{1.2, overlay::HeadBlur::Done::kHeadBesideLeg}}) {
    const overlay::HeadBlur blur(StandThenLean(lean, 0, 1));
    cv::Mat picture(800 * 3 / 2, 640, CV_8UC1, cv::Scalar(100));
    EXPECT_EQ(blur.Blur(picture, 0, 640), overlay::HeadBlur::Done::kHead) << "standing";
    EXPECT_EQ(blur.Blur(picture, 15, 640), done) << lean;
  }
}

// Head and neck of the real person: the head's middle a tenth of the stature beyond the seventh vertebra, the neck 25°
// before the trunk's line and nodding by 45° either way, the head 0.15 of the stature across (Drillis & Contini).
TEST(HeadBlur, CoversTheHeadInEveryFrameOfRealRises) {
  const std::filesystem::path file = SharedData() / "opencap_sts/sts_default_markers.trc";
  if (!std::filesystem::is_regular_file(file)) GTEST_SKIP() << "no real recordings in " << SharedData();
  for (const char* trunk : {"waist=r.ASIS", "waist=r.PSIS", "waist=r.ASIS+r.PSIS", "shoulder=R_Shoulder"}) {
    const auto [name, marker] =
        std::pair(std::string(trunk, std::string_view(trunk).find('=')),
                  std::string(std::string_view(trunk).substr(std::string_view(trunk).find('=') + 1)));
    exchange::TrialOptions reading;
    reading.names = {{"ankle", "r_ankle"}, {"knee", "r_knee"}, {"hip", "R_HJC"}, {name, marker}, {"c7", "C7"}};
    reading.up = 'y';
    reading.forward = "+x";
    motion::MarkerRecording tracks = exchange::ReadTrial(file, reading).recording;
    tracks.unit = motion::LengthUnit::kPx;
    for (motion::MarkerTrack& m : tracks.markers)
      for (motion::MarkerSample& s : m.samples) s.position = {0.2 * s.position.x(), 500 - 0.2 * s.position.y()};
    const motion::MarkerTrack c7 = *tracks.Find("c7"), hip = *tracks.Find("hip");
    std::erase_if(tracks.markers, [](const motion::MarkerTrack& m) { return m.name == "c7"; });
    const overlay::HeadBlur blur(tracks);
    const double stature_px = 0.2 * 924 / 0.491;
    double reach = 0;
    for (std::size_t i = 0; i < tracks.Frames(); ++i) {
      const auto head = blur.Head(tracks.frame[i]);
      ASSERT_TRUE(head) << trunk;
      const Vector2d along = (c7.samples[i].position - hip.samples[i].position).normalized();
      for (const double nod_deg : {-20.0, 25.0, 70.0}) {
        const Vector2d middle =
            c7.samples[i].position + Eigen::Rotation2Dd(nod_deg * CV_PI / 180) * along * 0.1 * stature_px;
        reach = std::max(reach, ((middle - head->centre).norm() + 0.075 * stature_px) / head->radius_px);
      }
    }
    EXPECT_LT(reach, 1) << trunk;
    EXPECT_GT(reach, 0.5) << trunk << ": a disc twice as wide as need be";
  }
}

TEST(HeadBlur, BridgesShortGapsAndBlursAllInLongOnes) {
  motion::MarkerRecording tracks = StandThenLean(0.5, 0, 1);
  for (std::size_t i = 3; i < 6; ++i) tracks.markers[3].samples[i].status = motion::SampleStatus::kMissing;
  EXPECT_TRUE(overlay::HeadBlur(tracks).Head(4));
  for (std::size_t i = 6; i < 16; ++i) tracks.markers[3].samples[i].status = motion::SampleStatus::kMissing;
  const overlay::HeadBlur blur(tracks);
  EXPECT_FALSE(blur.Head(8));
  EXPECT_FALSE(blur.Head(1000)) << "a frame that nobody tracked";
  cv::Mat picture(1080, 640, CV_8UC1);
  cv::randu(picture, 0, 255);
  const cv::Mat before = picture.clone();
  EXPECT_EQ(blur.Blur(picture, 8, 640), overlay::HeadBlur::Done::kWhole);
  EXPECT_EQ(picture.at<uchar>(500, 300), before.at<uchar>(500, 300)) << "the knee";
  int same = 0;
  for (int y = 0; y < 720; y += 7) same += picture.at<uchar>(y, 600) == before.at<uchar>(y, 600);
  EXPECT_LT(same, 10) << "what is far from the leg";
}

TEST(HeadBlur, WithoutSomebodyWhoStandsItKnowsNothing) {
  motion::MarkerRecording tracks = StandThenLean(0.5, 0, 1);
  for (motion::MarkerSample& hip : tracks.markers[2].samples) hip.position = {100, 500};  // a seated leg
  EXPECT_FALSE(overlay::HeadBlur(tracks).IsKnown());
}

TEST(HeadBlur, NamesTheMarkersThatAreMissing) {
  for (const char* missing : {"ankle", "hip", "waist"}) {
    motion::MarkerRecording tracks = StandThenLean(0.5, 0, 1);
    std::erase_if(tracks.markers, [&](const motion::MarkerTrack& m) { return m.name == missing; });
    EXPECT_THAT([&] { overlay::HeadBlur{tracks}; }, testing::ThrowsMessage<Error>(HasSubstr(missing)));
  }
}

std::vector<cv::Mat> Lumas(const std::filesystem::path& path) {
  std::vector<cv::Mat> lumas;
  const auto reader = video::VideoReader::Open(path);
  for (video::VideoFrame frame; reader->Read(frame);) lumas.push_back(frame.luma.clone());
  return lumas;
}

TEST(AnonymisedCopy, KeepsWhatIsNotTheHeadToTheBitInEitherRange) {
  const TemporaryFolder folder;
  const motion::MarkerRecording tracks = StandThenLean(0.5, 0, 1);
  for (const bool full_range : {false, true}) {
    {
      video::VideoWriter writer(
          folder / "in.mp4", {.width = 640, .height = 720, .lossless = true, .i420 = true, .full_range = full_range});
      cv::Mat picture(1080, 640, CV_8UC1);
      cv::randu(picture, full_range ? 0 : 16, full_range ? 256 : 236);
      for (const double time_s : tracks.time_s) {
        writer.Write(picture, time_s);
      }
      writer.Finish();
    }
    const overlay::HeadBlur blur(tracks);
    overlay::AnonymiseOptions quietly;
    quietly.quiet = true;
    const overlay::AnonymisedCopy copy = WriteAnonymisedVideo(folder / "in.mp4", blur, quietly, folder / "out.mp4");
    EXPECT_TRUE(copy.is_exact);
    EXPECT_EQ(copy.frames, 20);
    EXPECT_EQ(copy.whole, 0);
    const std::vector<cv::Mat> in = Lumas(folder / "in.mp4"), out = Lumas(folder / "out.mp4");
    ASSERT_EQ(in.size(), out.size());
    for (std::size_t i = 0; i < in.size(); ++i) {
      const auto head = blur.Head(static_cast<std::int64_t>(i));
      int blurred = 0, inside = 0;
      for (int y = 0; y < 720; y += 3)
        for (int x = 0; x < 640; x += 3) {
          const double distance_px = (Vector2d(x, y) - head->centre).norm();
          const bool same = in[i].at<uchar>(y, x) == out[i].at<uchar>(y, x);
          EXPECT_TRUE(same || distance_px <= head->radius_px + 2) << x << ',' << y;
          if (distance_px < head->radius_px - 2 && y < 200) ++inside, blurred += same ? 0 : 1;
        }
      EXPECT_GT(blurred, 0.95 * inside) << "frame " << i;
    }
  }
}

}  // namespace
}  // namespace lake
