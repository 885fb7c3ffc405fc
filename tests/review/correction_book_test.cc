// Corrections step by step.
#include "lake/review/correction_book.h"

#include <gmock/gmock.h>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/review/problems.h"
#include "temporary_folder.h"

namespace lake::review {
namespace {

using motion::MarkerSample;
using motion::SampleStatus;

// Two markers on straight paths over frames 10 to 19; `knee` is not seen in frame 13.
motion::MarkerRecording Recording() {
  motion::MarkerRecording recording;
  recording.markers = {{"ankle", {}}, {"knee", {}}};
  for (int i = 0; i < 10; ++i) {
    recording.frame.push_back(10 + i);
    recording.time_s.push_back(i / 30.0);
    recording.markers[0].samples.push_back({{100.0 + i, 300}, 0.03, SampleStatus::kDetected});
    recording.markers[1].samples.push_back({{110.0 + 2 * i, 200}, 0.05, SampleStatus::kDetected});
  }
  recording.markers[1].samples[3] = {};
  return recording;
}

const MarkerSample& At(const motion::MarkerRecording& recording, int frame, int marker) {
  return recording.markers[static_cast<std::size_t>(marker)].samples[static_cast<std::size_t>(frame - 10)];
}

TEST(CorrectionBook, ChangesWhatItWasToldAndNothingElse) {
  CorrectionBook book(Recording(), 640, 480, {});
  book.Place(12, "knee", {50, 60}, 0.5);
  book.Hide(14, "ankle");
  book.Place(13, "knee", {70, 80}, 0.2);
  const motion::MarkerRecording before = Recording(), after = book.Corrected();
  EXPECT_EQ(At(after, 12, 1).position, Eigen::Vector2d(50, 60));
  EXPECT_EQ(At(after, 13, 1).sigma, 0.2);
  EXPECT_FALSE(At(after, 14, 0).IsKnown());
  for (int frame = 10; frame < 20; ++frame)
    for (int marker = 0; marker < 2; ++marker) {
      const bool is_changed = (marker == 1 && (frame == 12 || frame == 13)) || (marker == 0 && frame == 14);
      if (is_changed) continue;
      EXPECT_EQ(At(after, frame, marker).IsKnown(), At(before, frame, marker).IsKnown());
      EXPECT_EQ(At(after, frame, marker).position, At(before, frame, marker).position);
    }
  EXPECT_EQ(book.Corrections().size(), 3u);
}

TEST(CorrectionBook, ALaterSessionTakesStepsBack) {
  CorrectionBook book(Recording(), 640, 480, {}, {{11, "ankle", {}}});
  book.Place(12, "knee", {50.125, 60}, 0.5);
  book.SwapFrom(15, "ankle", "knee");
  book.Hide(18, "knee");
  book.Undo();
  const Json history = Json::parse(book.History().dump());

  CorrectionBook later(Recording(), 640, 480, {}, book.Corrections());
  EXPECT_FALSE(later.CanUndo());
  later.TakeHistory(history);
  EXPECT_TRUE(later.CanRedo());
  later.Redo();
  EXPECT_FALSE(At(later.Corrected(), 18, 1).IsKnown());
  for (int i = 0; i < 3; ++i) later.Undo();
  EXPECT_FALSE(later.CanUndo());
  ASSERT_EQ(later.Count(), 1u) << "what was there before the first step";
  EXPECT_EQ(later.Corrections().front().frame, 11);
  later.Redo();
  later.Hide(10, "ankle");
  EXPECT_FALSE(later.CanRedo()) << "another step has taken its place";
  EXPECT_EQ(later.History().at("steps").size(), 2u);
}

TEST(CorrectionBook, MovesEventsAmongItsOtherSteps) {
  using motion::StsEventKind;
  CorrectionBook book(Recording(), 640, 480, {}, {}, {{1, StsEventKind::kOnset, {}, 0.05, {}}});
  EXPECT_EQ(book.Count(), 1u);
  book.MoveEvent(1, StsEventKind::kSeatOff, 14);
  book.Hide(12, "knee");
  book.MoveEvent(1, StsEventKind::kSeatOff, 15);
  EXPECT_THROW(book.MoveEvent(1, StsEventKind::kSeatOff, 15), Error) << "changes nothing";
  EXPECT_THROW(book.MoveEvent(1, StsEventKind::kSeatOff, 9), Error) << "outside";
  EXPECT_THROW(book.MoveEvent(0, StsEventKind::kSeatOff, 15), Error);
  EXPECT_THROW(book.RestoreEvent(2, StsEventKind::kSeatOff), Error) << "was not moved";
  EXPECT_EQ(book.Events()[1].time_s, 5 / 30.0);
  book.RestoreEvent(1, StsEventKind::kOnset);
  const Json history = Json::parse(book.History().dump());
  CorrectionBook later(Recording(), 640, 480, {}, book.Corrections(), book.Events());
  later.TakeHistory(history);
  later.Undo();
  EXPECT_EQ(later.Events().front().time_s, 0.05) << "what was there before the first step";
  later.Undo();
  EXPECT_EQ(later.Events()[1].frame, 14);
  later.Undo();
  later.Undo();
  EXPECT_FALSE(later.CanUndo());
  EXPECT_FALSE(later.IsMoved(1, StsEventKind::kSeatOff));
  later.Redo();
  EXPECT_EQ(later.Events()[1].frame, 14);
  CorrectionBook by_hand(Recording(), 640, 480, {}, book.Corrections());
  EXPECT_THAT([&] { by_hand.TakeHistory(history); }, testing::ThrowsMessage<Error>(testing::HasSubstr("were changed")));
}

TEST(CorrectionBook, TakesNoStepsOfOtherCorrections) {
  CorrectionBook book(Recording(), 640, 480, {});
  book.Hide(12, "knee");
  const Json history = book.History();
  CorrectionBook edited(Recording(), 640, 480, {}, {{12, "knee", {}}, {13, "ankle", {}}});  // corrections.csv by hand
  EXPECT_THAT([&] { edited.TakeHistory(history); }, testing::ThrowsMessage<Error>(testing::HasSubstr("were changed")));
  EXPECT_EQ(edited.Count(), 2u);
  EXPECT_FALSE(edited.CanUndo());
  Json damaged = history;
  damaged["done"] = 1.5;
  EXPECT_THROW(edited.TakeHistory(damaged), Error);
  damaged = history;
  damaged["steps"][0]["frame"] = 99;
  EXPECT_THROW(edited.TakeHistory(damaged), Error);
}

TEST(CorrectionBook, TakesEachStepBack) {
  CorrectionBook book(Recording(), 640, 480, {});
  EXPECT_FALSE(book.CanUndo());
  book.Place(12, "knee", {50, 60}, 0.5);
  book.Place(12, "knee", {51, 61}, 0.5);
  book.SwapFrom(15, "ankle", "knee");
  book.Undo();
  book.Undo();
  EXPECT_EQ(At(book.Corrected(), 12, 1).position, Eigen::Vector2d(50, 60));
  book.Redo();
  EXPECT_EQ(At(book.Corrected(), 12, 1).position, Eigen::Vector2d(51, 61));
  book.Undo();
  book.Undo();
  EXPECT_TRUE(book.Corrections().empty());
  EXPECT_THROW(book.Undo(), Error);
  book.Hide(10, "ankle");
  EXPECT_FALSE(book.CanRedo()) << "what was undone is gone once another step is made";
}

TEST(CorrectionBook, SwapsNamesWithTheirSigmasFromHereOn) {
  CorrectionBook book(Recording(), 640, 480, {});
  book.SwapFrom(12, "ankle", "knee");
  const motion::MarkerRecording before = Recording(), after = book.Corrected();
  EXPECT_EQ(At(after, 11, 0).position, At(before, 11, 0).position);
  EXPECT_EQ(At(after, 12, 0).position, At(before, 12, 1).position);
  EXPECT_EQ(At(after, 12, 0).sigma, 0.05);
  EXPECT_FALSE(At(after, 13, 0).IsKnown());
  EXPECT_EQ(At(after, 13, 1).position, At(before, 13, 0).position);
  book.SwapFrom(12, "ankle", "knee");
  EXPECT_TRUE(book.Corrections().empty()) << "swapped twice is as it was detected";
}

TEST(CorrectionBook, RestoresWhatWasDetected) {
  CorrectionBook book(Recording(), 640, 480, {},
                      {{12, "knee", {}}, {13, "knee", {{1, 2}, 0.5, SampleStatus::kDetected}}});
  EXPECT_EQ(book.Count(), 2u);
  EXPECT_FALSE(book.CanUndo()) << "made before";
  book.Restore(12, "knee");
  book.Restore(13, "knee");
  EXPECT_EQ(book.Count(), 0u);
  EXPECT_FALSE(At(book.Corrected(), 13, 1).IsKnown());
}

TEST(CorrectionBook, RefusesWhatCannotBe) {
  CorrectionBook book(Recording(), 640, 480, {15});
  EXPECT_THROW(book.Place(9, "knee", {1, 1}, 0.5), Error);
  EXPECT_THROW(book.Place(12, "elbow", {1, 1}, 0.5), Error);
  EXPECT_THROW(book.Place(12, "knee", {NAN, 1}, 0.5), Error);
  EXPECT_THROW(book.Place(12, "knee", {1, 1}, 0), Error);
  EXPECT_THROW(book.Place(12, "knee", {639.5, 1}, 0.5), Error) << "outside the picture; its reader would refuse it";
  EXPECT_THROW(book.Place(12, "knee", {1, -0.1}, 0.5), Error);
  EXPECT_THROW(book.Place(15, "knee", {1, 1}, 0.5), Error) << "a repeated frame holds no measurement";
  EXPECT_THROW(book.Restore(12, "knee"), Error) << "changes nothing";
  EXPECT_THROW(book.Hide(13, "knee"), Error) << "is not seen anyway";
  EXPECT_THROW(book.SwapFrom(12, "knee", "knee"), Error);
  EXPECT_FALSE(book.CanUndo());
}

TEST(Corrections, AreReadAsTheyWereWritten) {
  const TemporaryFolder folder;
  CorrectionBook book(Recording(), 640, 480, {});
  book.Place(12, "knee", {50.123456789012345, 60}, 0.0123);
  book.Hide(14, "ankle");
  motion::WriteCorrections(folder / "corrections.csv", book.Corrections());
  const auto read = motion::ReadCorrections(folder / "corrections.csv", {"ankle", "knee"}, 640, 480);
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].sample.position, Eigen::Vector2d(50.123456789012345, 60));
  EXPECT_EQ(read[0].sample.sigma, 0.0123);
  EXPECT_FALSE(read[1].sample.IsKnown());
}

TEST(Corrections, OfOneMarkerInOneFrameMustBeOne) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& rows) {
    WriteTextFile(folder / "corrections.csv", "frame,marker,x_px,y_px\n" + rows);
    return motion::ReadCorrections(folder / "corrections.csv", {"ankle", "knee"}, 640, 480);
  };
  EXPECT_EQ(read("12,knee,50,60\n12,ankle,50,60\n13,knee,50,60\n").size(), 3u);
  EXPECT_THAT([&] { read("12,knee,50,60\n13,knee,1,2\n12,knee,,\n"); },
              testing::ThrowsMessage<Error>(
                  testing::AllOf(testing::HasSubstr("corrections.csv:4: 'knee' in frame 12 is corrected twice"),
                                 testing::HasSubstr("corrections.csv:2"))));
}

TEST(Problems, AreGapsOutliersUncertainAndStretchedSegments) {
  motion::MarkerRecording recording = Recording();
  recording.markers[0].samples[8].sigma = 0.5;
  recording.markers[1].samples[9].position.y() = 100;
  gait::LegFitResult leg;
  leg.outliers = {{11, "knee", 3.5, 9}};
  const std::vector<Problem> problems = FindProblems(recording, &leg, {});
  ASSERT_EQ(problems.size(), 4u);
  EXPECT_EQ(problems[0].kind, ProblemKind::kOutlier);
  EXPECT_EQ(problems[1].kind, ProblemKind::kGap);
  EXPECT_EQ(problems[1].first, 13);
  EXPECT_EQ(problems[2].kind, ProblemKind::kUncertain);
  EXPECT_EQ(problems[2].first, 18);
  EXPECT_EQ(problems[3].kind, ProblemKind::kLength);
  EXPECT_GT(problems[3].value, 1.8);
  EXPECT_EQ(FindProblems(recording, &leg, {13}).size(), 3u) << "in a repeated frame nothing is missed";
}

// Standard deviations are far below 1 px in good recordings.
TEST(Problems, TellTheLargestUncertainty) {
  motion::MarkerRecording recording = Recording();
  recording.markers[0].samples[7].sigma = 0.1;
  recording.markers[0].samples[8].sigma = 0.9;
  for (std::size_t row = 0; row < recording.Frames(); ++row)
    if (row != 7 && row != 8) recording.markers[0].samples[row].sigma = 0.02;
  const std::vector<Problem> problems = FindProblems(recording, nullptr, {});
  const auto found = std::find_if(problems.begin(), problems.end(),
                                  [](const Problem& problem) { return problem.kind == ProblemKind::kUncertain; });
  ASSERT_NE(found, problems.end());
  EXPECT_EQ(found->value, 0.9);
}

}  // namespace
}  // namespace lake::review
