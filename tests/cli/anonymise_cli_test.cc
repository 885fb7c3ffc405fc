// lake-anonymise on a rendering that shows a head.
#include <gmock/gmock.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "cli/program_run.h"
#include "lake/core/csv.h"
#include "lake/motion/marker_recording.h"
#include "lake/video/video_reader.h"

namespace lake {
namespace {

using Eigen::Vector2d;

// The programs' true pixels of one frame, and how many of them are a mm.
struct Body {
  Vector2d hip, waist, knee;
  double px_per_mm;

  Vector2d OnTrunk(double up_mm, double front_mm) const {
    const Vector2d up = (waist - hip).normalized(), front(-up.y(), up.x());
    return hip + px_per_mm * (up_mm * up + front_mm * front);
  }
};

Body BodyIn(const CsvTable& truth, std::size_t row) {
  const auto place = [&](const std::string& name) {
    return Vector2d(*truth.Number(row, truth.Column(name + "_x_px")), *truth.Number(row, truth.Column(name + "_y_px")));
  };
  Body body{place("hip"), place("waist"), place("knee"), 0};
  body.px_per_mm = (body.waist - body.hip).norm() / 200;
  return body;
}

class AnonymiseProgram : public testing::Test {
 protected:
  // 60 frames, from the seat to standing and back, with the whole person in the picture.
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    Done(*folder_,
         "lake-synth --repetitions 1 --width 360 --height 600 --rate 12 --distance 5600 --radius-px 2.5 "
         "--seed-number 731 -o good --quiet && lake-track good/video.mp4 --camera good/camera.yaml "
         "--no-overlay --quiet -o trial");
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::unique_ptr<TemporaryFolder> folder_;
};

std::unique_ptr<TemporaryFolder> AnonymiseProgram::folder_;

const std::string kAnonymise = "lake-anonymise --quiet -o copy ";

// The steepest step between neighbours.
double Edge(const cv::Mat& luma, const Vector2d& place) {
  const int x = cvRound(place.x()), y = cvRound(place.y());
  if (x < 3 || y < 3 || x > luma.cols - 4 || y > luma.rows - 4) return 0;
  double steepest = 0;
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx) {
      const int here = luma.at<uchar>(y + dy, x + dx);
      steepest = std::max({steepest, std::abs(1.0 * here - luma.at<uchar>(y + dy, x + dx + 1)),
                           std::abs(1.0 * here - luma.at<uchar>(y + dy + 1, x + dx))});
    }
  return steepest;
}

TEST_F(AnonymiseProgram, BlursTheWholeHeadInEveryFrameAndNothingOfTheLeg) {
  Done(*folder_, kAnonymise + "good/video.mp4 --trial trial");
  const CsvTable truth = CsvTable::Read(*folder_ / "good/truth.csv");
  const auto before = video::VideoReader::Open(*folder_ / "good/video.mp4"),
             after = video::VideoReader::Open(*folder_ / "copy/anonymised.mp4");
  video::VideoFrame a, b;
  int edges_before = 0, edges_after = 0, frames = 0;
  for (std::size_t row = 0; before->Read(a) && after->Read(b); ++row, ++frames) {
    ASSERT_NEAR(a.time_s, b.time_s, 1.0 / 90000);
    const Body body = BodyIn(truth, row);
    // The hair's outline, as the renderer draws it: from 640 to 720 mm up the trunk, 92 to 96 mm wide; and the face
    // before it.
    for (double angle = 0; angle < 6.28; angle += 0.2) {
      const Vector2d hair = body.OnTrunk(700 + 95 * std::sin(angle), 18 + 95 * std::cos(angle));
      const Vector2d face = body.OnTrunk(650 + 70 * std::sin(angle), 58 + 68 * std::cos(angle));
      for (const Vector2d& place : {hair, face}) {
        edges_before += Edge(a.luma, place) > 15;
        edges_after += Edge(b.luma, place) > 15;
      }
    }
    // A square of 110 mm around knee and hip, a marker's surroundings.
    for (const Vector2d& place : {body.knee, body.hip}) {
      const int radius = static_cast<int>(55 * body.px_per_mm);
      const cv::Rect around(cvRound(place.x()) - radius, cvRound(place.y()) - radius, 2 * radius, 2 * radius);
      EXPECT_EQ(cv::norm(a.luma(around), b.luma(around), cv::NORM_INF), 0) << "frame " << row;
    }
  }
  EXPECT_EQ(frames, static_cast<int>(truth.Rows()));
  EXPECT_GT(edges_before, 5 * frames) << "the rendering shows a head";
  EXPECT_EQ(edges_after, 0);
}

TEST_F(AnonymiseProgram, TheCopyIsTrackedAsTheRecording) {
  Done(*folder_, kAnonymise + "good/video.mp4 --trial trial");
  Done(*folder_, "lake-track copy/anonymised.mp4 --camera good/camera.yaml --no-overlay --quiet -o again");
  const motion::MarkerRecording first = motion::ReadMarkerCsv(*folder_ / "trial/tracks.csv"),
                                second = motion::ReadMarkerCsv(*folder_ / "again/tracks.csv");
  for (const char* name : {"ankle", "knee", "hip"})
    for (std::size_t i = 0; i < first.Frames(); ++i) {
      // What is not blurred is the same to the bit, but the picture's noise is estimated from all of it: 0.73 of a
      // standard deviation at most with this seed.
      const motion::MarkerSample &a = first.Find(name)->samples[i], &b = second.Find(name)->samples[i];
      EXPECT_LT((a.position - b.position).norm(), a.sigma) << name << ", frame " << i;
    }
}

TEST_F(AnonymiseProgram, RefusesAnotherVideosTrialAndTheSummaryOfNone) {
  Done(*folder_, "ffmpeg -y -v error -i good/video.mp4 -t 1 other.mp4");
  ExpectRefused(*folder_, kAnonymise + "other.mp4 --trial trial", 1, "contents differ");
  ExpectRefused(*folder_, kAnonymise + "good/video.mp4 --trial nowhere", 1, "nowhere");
  ExpectRefused(*folder_, kAnonymise + "good/video.mp4", 2, "--trial");
  ExpectRefused(*folder_, kAnonymise + "good/video.mp4 --trial trial --rotate 90", 1, "--rotate");
}

TEST_F(AnonymiseProgram, TrackingMakesAnOverlayWithoutAFace) {
  Done(*folder_,
       "lake-track good/video.mp4 --anonymise --quiet -o shown && "
       "lake-track good/video.mp4 --anonymise --list --quiet -o listed");
  const CsvTable truth = CsvTable::Read(*folder_ / "good/truth.csv");
  const cv::Mat overlay = video::ReadLuma(*folder_ / "shown/overlay.mp4", 30);
  const Body body = BodyIn(truth, 30);
  for (double angle = 0; angle < 6.28; angle += 0.2)
    EXPECT_LT(Edge(overlay, body.OnTrunk(700 + 95 * std::sin(angle), 18 + 95 * std::cos(angle))), 15);
  EXPECT_TRUE(std::filesystem::exists(*folder_ / "listed/candidates.png"));
  ExpectRefused(*folder_, "lake-track good/video.mp4 --anonymise --markers ankle,knee,hip -o none", 2, "--anonymise");
}

}  // namespace
}  // namespace lake
