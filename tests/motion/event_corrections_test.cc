// Events that a person moved.
#include "lake/motion/event_corrections.h"

#include <gmock/gmock.h>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "temporary_folder.h"

namespace lake::motion {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr auto kOnset = StsEventKind::kOnset, kSeatOff = StsEventKind::kSeatOff, kStanding = StsEventKind::kStanding,
               kDescent = StsEventKind::kDescent, kSeated = StsEventKind::kSeated;

// Frames 100 to 199 at 10 per s from 2 s on; two sit-to-stands, of which the second is cut off.
class EventCorrections : public testing::Test {
 protected:
  EventCorrections() {
    for (int i = 0; i < 100; ++i) frame_.push_back(100 + i), time_s_.push_back(2 + i / 10.0);
    const auto add = [this](int repetition, StsEventKind kind, std::size_t row) {
      found_.push_back({repetition, kind, frame_[row], time_s_[row]});
    };
    add(1, kOnset, 5);
    add(1, kSeatOff, 10);
    add(1, kStanding, 20);
    add(1, kDescent, 30);
    add(1, kSeated, 45);
    add(2, kOnset, 60);
    add(2, kSeatOff, 66);
    add(2, kStanding, 80);
  }

  std::vector<EventCorrection> Read(const std::string& text) const {
    WriteTextFile(folder_ / "e.csv", text);
    return ReadEventCorrections(folder_ / "e.csv");
  }

  std::vector<StsEvent> Apply(const std::string& rows) const {
    return ApplyEventCorrections(Read("repetition,event,frame,time_s\n" + rows), frame_, time_s_, found_);
  }

  void ExpectError(const std::string& rows, const std::string& text) const {
    EXPECT_THAT([&] { Apply(rows); }, ThrowsMessage<Error>(AllOf(HasSubstr("e.csv:2: "), HasSubstr(text)))) << rows;
  }

  static const StsEvent* Find(const std::vector<StsEvent>& events, int repetition, StsEventKind kind) {
    for (const StsEvent& event : events)
      if (event.repetition == repetition && event.kind == kind) return &event;
    return nullptr;
  }

  TemporaryFolder folder_;
  std::vector<std::int64_t> frame_;
  std::vector<double> time_s_;
  std::vector<StsEvent> found_;
};

TEST_F(EventCorrections, ReplaceThoseThatWereFoundAndNoOthers) {
  const std::vector<StsEvent> events = Apply("1,seat_off,112,\n2,standing,,9.93\n");
  ASSERT_EQ(events.size(), found_.size());
  EXPECT_EQ(Find(events, 1, kSeatOff)->frame, 112);
  EXPECT_EQ(Find(events, 1, kSeatOff)->time_s, time_s_[12]);
  EXPECT_EQ(Find(events, 2, kStanding)->time_s, 9.93) << "a force plate is more exact than the frames";
  EXPECT_EQ(Find(events, 2, kStanding)->frame, 179) << "the nearest";
  for (const StsEvent& event : found_) {
    if ((event.repetition == 1 && event.kind == kSeatOff) || (event.repetition == 2 && event.kind == kStanding))
      continue;
    EXPECT_EQ(Find(events, event.repetition, event.kind)->frame, event.frame);
  }
}

TEST_F(EventCorrections, AddAndTakeAway) {
  const std::vector<StsEvent> events = Apply("2,descent,185,\n1,seated,,\n3,onset,190,\n3,standing,198,\n");
  ASSERT_EQ(events.size(), found_.size() + 2);
  EXPECT_EQ(Find(events, 1, kSeated), nullptr);
  EXPECT_EQ(events[7].kind, kDescent);
  EXPECT_EQ(events.back().repetition, 3);
  const std::vector<StsEvent> second = Apply("1,onset,,\n1,seat_off,,\n1,standing,,\n1,descent,,\n1,seated,,\n");
  ASSERT_EQ(second.size(), 3u);
  EXPECT_EQ(second.front().repetition, 2);
}

TEST_F(EventCorrections, OfAWholeTableAreThatTable) {
  WriteEventsCsv(folder_ / "events.csv", found_);
  const std::vector<StsEvent> events =
      ApplyEventCorrections(ReadEventCorrections(folder_ / "events.csv"), frame_, time_s_, {});
  ASSERT_EQ(events.size(), found_.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].frame, found_[i].frame);
    EXPECT_EQ(events[i].time_s, found_[i].time_s);
  }
}

TEST_F(EventCorrections, AreReadAsTheyWereWritten) {
  const std::vector<EventCorrection> written = {
      {1, kOnset, 104, 2.4, {}}, {1, kSeatOff, {}, 1 / 3.0, {}}, {2, kOnset, {}, {}, {}}};
  WriteEventCorrections(folder_ / "e.csv", written);
  const std::vector<EventCorrection> read = ReadEventCorrections(folder_ / "e.csv");
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].repetition, written[i].repetition);
    EXPECT_EQ(read[i].kind, written[i].kind);
    EXPECT_EQ(read[i].frame, written[i].frame);
    EXPECT_EQ(read[i].time_s, written[i].time_s);
  }
  EXPECT_EQ(Read("repetition,event,time_s\n1,onset,2.5\n").front().time_s, 2.5);
  EXPECT_EQ(Read("repetition,event,frame\n1,onset,105\n").front().frame, 105);
}

TEST_F(EventCorrections, ThatCannotBeAreErrorsWithTheirLine) {
  ExpectError("1,sitting,,2.5\n", "'sitting' is not an event; there are onset, seat_off, standing, descent, seated");
  ExpectError("0,onset,,2.5\n", "repetition 0 is not a whole number from 1");
  ExpectError("1.5,onset,,2.5\n", "repetition 1.5");
  ExpectError("1,onset,3.5,\n", "frame 3.5");
  ExpectError("1,onset,99,\n", "frame 99 is not in the recording; its frames are 100 to 199");
  ExpectError("1,onset,,1.9\n", "1.9 s is outside the recording, which is from 2.000 to 11.900 s");
  ExpectError("1,onset,103,2.4\n", "frame 103 is at 2.300 s, not at 2.4 s");
  ExpectError("1,onset,,soon\n", "'soon' is not a finite number");
  ExpectError("1,seat_off,104,\n", "seat_off of repetition 1 at 2.400 s is before onset of repetition 1 at 2.500 s");
  ExpectError("1,seated,170,\n", "onset of repetition 2 at 8.000 s is before seated of repetition 1 at 9.000 s");
  ExpectError("1,onset,111,\n", "seat_off of repetition 1 at 3.000 s is before onset");
  ExpectError("1,onset,,\n", "repetition 1 has no onset");
  ExpectError("3,standing,195,\n", "repetition 3 has no onset");
  ExpectError("3,standing,195,\n3,onset,195,\n", "a rise takes time");
  EXPECT_THAT([&] { Apply("1,onset,104,\n1,onset,105,\n"); },
              ThrowsMessage<Error>(HasSubstr("e.csv:3: onset of repetition 1 is given twice")));
  EXPECT_THAT([&] { Read("repetition,event\n1,onset\n"); },
              ThrowsMessage<Error>(HasSubstr("no column 'frame' or 'time_s'")));
}

}  // namespace
}  // namespace lake::motion
