#include "lake/camera/board.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <iterator>

#include "board_scene.h"
#include "lake/core/error.h"
#include "message_of.h"

namespace lake {
namespace {

TEST(Board, TextAndBoardAreTheSameThing) {
  for (const char* text :
       {"chessboard:9x6:25", "chessboard:9x6:24.5", "charuco:9x7:25:18:4X4_50", "charuco:11x8:35:26:APRILTAG_36h11"})
    EXPECT_EQ(camera::ToString(camera::ParseBoard(text)), text);
  EXPECT_EQ(camera::ToString(camera::ParseBoard("charuco:9x7:25:18:dict_4x4_50")), "charuco:9x7:25:18:4X4_50");
}

TEST(Board, WrongTextsAreUsageErrorsThatSayWhatIsWrong) {
  const auto complaint = [](const char* text) { return MessageOf<UsageError>([&] { camera::ParseBoard(text); }); };
  using testing::HasSubstr;
  EXPECT_THAT(complaint(""), HasSubstr("must begin with"));
  EXPECT_THAT(complaint("circles:9x6:25"), HasSubstr("must begin with"));
  EXPECT_THAT(complaint("chessboard:9x6"), HasSubstr("2 parts, not 3"));
  EXPECT_THAT(complaint("chessboard:9:25"), HasSubstr("'9' is not COLSxROWS"));
  EXPECT_THAT(complaint("chessboard:9x2:25"), HasSubstr("3 to 100 rows"));
  EXPECT_THAT(complaint("chessboard:9.5x6:25"), HasSubstr("'9.5' is no number of columns"));
  EXPECT_THAT(complaint("chessboard:1e300x6:25"), HasSubstr("no number of columns"));
  EXPECT_THAT(complaint("chessboard:9x6:0"), HasSubstr("'0' is no size"));
  EXPECT_THAT(complaint("chessboard:9x6:0.025"), HasSubstr("a square of 0.025 mm is smaller than any (is it in m?)"));
  EXPECT_THAT(complaint("charuco:9x7:25:0.018:4X4_50"), HasSubstr("a marker of 0.018 mm"));
  EXPECT_THAT(complaint("chessboard:9x6:nan"), HasSubstr("'nan' is no size"));
  EXPECT_THAT(complaint("charuco:9x7:25:26:4X4_50"), HasSubstr("does not fit"));
  EXPECT_THAT(complaint("charuco:9x7:25:18:4X4_51"), HasSubstr("no dictionary '4X4_51'; known: 4X4_50"));
  EXPECT_THAT(complaint("charuco:20x20:25:18:4X4_50"), HasSubstr("needs 200 markers, 4X4_50 has 50"));
}

TEST(Board, CornersGoFromTheLowerLeftAlongRows) {
  const camera::Board board = camera::ParseBoard("chessboard:9x6:25");
  const auto corners = camera::BoardCorners(board);
  ASSERT_EQ(corners.size(), 54u);
  EXPECT_EQ(corners[0], Eigen::Vector2d(0, 0));
  EXPECT_EQ(corners[8], Eigen::Vector2d(200, 0));
  EXPECT_EQ(corners[9], Eigen::Vector2d(0, 25));
  EXPECT_EQ(camera::BoardCorners(camera::ParseBoard("charuco:9x7:25:18:4X4_50")).size(), 48u);
}

// 70 squares, half of them black.
TEST(Board, InkOfAChessboardIsHalfOfIt) {
  double area = 0;
  for (const auto& r : camera::BoardInk(camera::ParseBoard("chessboard:9x6:25"))) area += r.width * r.height;
  EXPECT_DOUBLE_EQ(area, 35 * 625.0);
}

class DetectBoardTest : public testing::TestWithParam<const char*> {};

// What the detector finds in rendered pictures against the projected corners: no bias, and an error well under 0.1 px.
TEST_P(DetectBoardTest, FindsEveryCornerOfRenderedBoardsWhereItIs) {
  const camera::Board board = camera::ParseBoard(GetParam());
  const camera::Camera camera = scene::Lens();
  std::mt19937_64 random(17);
  std::vector<Eigen::Vector2d> errors;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Isometry3d pose = scene::PoseWellInside(camera, board, random, 60);
    const auto truth = scene::CornerPixels(camera, board, pose);
    const auto view = camera::DetectBoard(scene::Render(camera, board, pose, random), board);
    ASSERT_TRUE(view) << "picture " << i;
    ASSERT_EQ(view->corner.size(), truth.size()) << "picture " << i;
    std::ranges::copy(scene::Errors(*view, truth), std::back_inserter(errors));
    EXPECT_GT(view->edge_width_px, 1);
    EXPECT_LT(view->edge_width_px, 4);  // pixel and blur of 0.6 px: 1.7 px across an edge, more on a slanted one
  }
  RecordProperty("rms_px", std::to_string(scene::RmsPx(errors)));
  EXPECT_LT(scene::RmsPx(errors), 0.08);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& error : errors) {
    EXPECT_LT(error.norm(), 0.4);
    sum += error;
  }
  EXPECT_LT((sum / static_cast<double>(errors.size())).norm(), 0.015);
}

TEST_P(DetectBoardTest, FindsABoardThatIsPrintedWhiteOnBlack) {
  const camera::Board board = camera::ParseBoard(GetParam());
  const camera::Camera camera = scene::Lens();
  std::mt19937_64 random(5);
  const cv::Mat picture =
      scene::Render(camera, board, scene::PoseAt(camera, board, {640, 360}, 450, 20, 10, 0), random);
  const auto positive = camera::DetectBoard(picture, board), negative = camera::DetectBoard(255 - picture, board);
  ASSERT_TRUE(positive && negative);
  ASSERT_EQ(negative->corner, positive->corner);
  for (const Eigen::Vector2d& error : scene::Errors(*negative, positive->pixel)) EXPECT_LT(error.norm(), 0.1);
}

INSTANTIATE_TEST_SUITE_P(Boards, DetectBoardTest, testing::Values("chessboard:9x6:25", "charuco:9x7:25:18:4X4_50"));

// An even number of rows in both of OpenCV's layouts: the text of the board is the same, and so must be the corners.
TEST(DetectBoard, FindsACharucoBoardOfEitherLayout) {
  const camera::Board board = camera::ParseBoard("charuco:7x10:30:22:4X4_50");
  const camera::Camera camera = scene::Lens();
  std::mt19937_64 random(3);
  for (const bool is_white : {false, true}) {
    camera::Board printed = board;
    printed.white_top_left = is_white;
    for (const double roll_deg : {0.0, 90.0, 200.0}) {
      const Eigen::Isometry3d pose = scene::PoseAt(camera, board, {640, 360}, 330, 25, 30, roll_deg);
      const auto view = camera::DetectBoard(scene::Render(camera, printed, pose, random), board);
      ASSERT_TRUE(view) << is_white << " " << roll_deg;
      const auto truth = scene::CornerPixels(camera, board, pose);
      EXPECT_GT(view->corner.size(), truth.size() - 4);
      for (std::size_t i = 0; i < view->corner.size(); ++i)
        EXPECT_LT((view->pixel[i] - truth[static_cast<std::size_t>(view->corner[i])]).norm(), 0.5);
    }
  }
}

// Other columns: the same codes lie elsewhere, in both layouts.
TEST(DetectBoard, DoesNotSeeACharucoBoardOfOtherColumns) {
  const camera::Camera camera = scene::Lens();
  std::mt19937_64 random(3);
  const camera::Board printed = camera::ParseBoard("charuco:7x10:30:22:4X4_50");
  const cv::Mat picture =
      scene::Render(camera, printed, scene::PoseAt(camera, printed, {640, 360}, 330, 20, 30, 0), random);
  EXPECT_TRUE(camera::DetectBoard(picture, printed));
  for (const char* text : {"charuco:10x7:30:22:4X4_50", "charuco:8x10:30:22:4X4_50", "charuco:6x10:30:22:4X4_50",
                           "charuco:9x8:30:22:4X4_50"})
    EXPECT_FALSE(camera::DetectBoard(picture, camera::ParseBoard(text))) << text;
}

TEST(DetectBoard, SeesNothingWhereThereIsNothing) {
  std::mt19937_64 random(1);
  cv::Mat1b noise(240, 320);
  for (uchar& v : noise) v = static_cast<uchar>(random() % 256);
  for (const char* text : {"chessboard:9x6:25", "charuco:9x7:25:18:4X4_50"}) {
    EXPECT_FALSE(camera::DetectBoard(noise, camera::ParseBoard(text)));
    EXPECT_FALSE(camera::DetectBoard(cv::Mat1b(480, 640, uchar{0}), camera::ParseBoard(text)));
    EXPECT_FALSE(camera::DetectBoard(cv::Mat1b(1, 1, uchar{0}), camera::ParseBoard(text)));
  }
  EXPECT_THROW(camera::DetectBoard(cv::Mat(), camera::ParseBoard("chessboard:9x6:25")), Error);
}

// Rows run upwards on the sheet whichever way it hangs.
TEST(DetectBoard, GridIsNeverMirrored) {
  const camera::Board board = camera::ParseBoard("chessboard:9x6:25");
  const camera::Camera camera = scene::Lens();
  std::mt19937_64 random(2);
  for (const double roll : {0.0, 90.0, 215.0}) {
    const auto pose = scene::PoseAt(camera, board, {640, 360}, 450, 20, 70, roll);
    const auto view = camera::DetectBoard(scene::Render(camera, board, pose, random, {0.6, 1.5, 2}), board);
    ASSERT_TRUE(view) << roll;
    const Eigen::Vector2d along = view->pixel[8] - view->pixel[0], up = view->pixel[45] - view->pixel[0];
    EXPECT_LT(along.x() * up.y() - along.y() * up.x(), 0) << roll;
  }
}

TEST(DetectBoard, ACharucoBoardMayBePartlyHidden) {
  const camera::Board board = camera::ParseBoard("charuco:9x7:25:18:4X4_50");
  const camera::Camera camera = scene::Lens();
  std::mt19937_64 random(3);
  const auto pose = scene::PoseAt(camera, board, {640, 360}, 700, 25, 30, 10);
  const auto truth = scene::CornerPixels(camera, board, pose);
  cv::Mat1b picture = scene::Render(camera, board, pose, random);
  picture(cv::Rect(0, 0, 600, 720)) = uchar{120};
  const auto view = camera::DetectBoard(picture, board);
  ASSERT_TRUE(view);
  EXPECT_LT(view->corner.size(), truth.size());
  EXPECT_GE(view->corner.size(), 12u);
  for (std::size_t i = 0; i < view->corner.size(); ++i)
    EXPECT_LT((view->pixel[i] - truth[static_cast<std::size_t>(view->corner[i])]).norm(), 0.5) << view->corner[i];
}

// A window that reaches the next corner spoils the result: the reason for choosing it by the spacing.
TEST(DetectBoard, WindowFollowsTheSpacing) {
  const camera::Board board = camera::ParseBoard("chessboard:9x6:25");
  const camera::Camera camera = scene::Lens();
  std::mt19937_64 random(4);
  const auto pose = scene::PoseAt(camera, board, {640, 360}, 110, 30, 20, 0);  // 12 px between corners
  const auto truth = scene::CornerPixels(camera, board, pose);
  const cv::Mat1b picture = scene::Render(camera, board, pose, random);
  const auto rms = [&](int half_window) {
    camera::BoardDetectionOptions options;
    options.half_window_px = half_window;
    const auto view = camera::DetectBoard(picture, board, options);
    return view ? scene::RmsPx(scene::Errors(*view, truth)) : std::nan("");
  };
  EXPECT_LT(rms(0), 0.15);
  EXPECT_GT(rms(11), 3 * rms(0));
}

}  // namespace
}  // namespace lake
