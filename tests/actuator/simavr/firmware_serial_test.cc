// The serial line as it is on the chip: bytes back to back at 115200 baud into a receiver that holds two.
#include <fmt/format.h>

#include <cstdlib>
#include <random>

#include "firmware_fixture.h"
#include "lake/actuator/stroke_session.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

class FirmwareSerialTest : public FirmwareTest {
 protected:
  void SetUp() override {
    WireSensors(firmware_options_);
    Build(FreeDesign({{0, 300}, {30, 330}}), "");
    rig_->Run(0.1);
  }

  // Lines of the firmware that are an answer, since `from`.
  std::vector<std::string> AnswersSince(std::size_t from) const {
    std::vector<std::string> answers;
    std::istringstream lines(rig_->Serial().substr(from));
    for (std::string line; std::getline(lines, line);)
      if (line == "ok" || line.starts_with("error:")) answers.push_back(line);
    return answers;
  }
  void RunUntilAnswered() {
    for (std::size_t said = 0; said != rig_->Serial().size() || rig_->Receiver().Waiting() > 0;)
      said = rig_->Serial().size(), rig_->Run(0.05);
  }
  // Where nothing may move.
  void ExpectStill() const {
    for (const RigSample& sample : rig_->Samples()) ASSERT_EQ(sample.duty, 0) << sample.time_s;
  }
};

// Lines of which many have another answer than their neighbours, so that none can be lost, doubled or taken for
// another. On average they are longer than what is said, answers and rows: the way back is no faster. 10 000 with
// LAKE_LONG_TESTS=1 in the environment.
TEST_F(FirmwareSerialTest, OfLinesBackToBackNoneIsLostAndNoneIsWrong) {
  rig_->KeepTalking(false);
  const int count = std::getenv("LAKE_LONG_TESTS") ? 10'000 : 1'000;
  const std::pair<const char*, const char*> kinds[] = {{"jog -300 99999", "error:2"},
                                                       {"stop", "ok"},
                                                       {"jgo -300 100", "error:1"},
                                                       {"stop", "ok"},
                                                       {"jog 0 1000", "error:2"}};
  std::mt19937 random(5);
  std::vector<std::string> expected;
  std::string all;
  for (int i = 0; i < count; ++i) {
    const auto& [line, answer] = kinds[random() % std::size(kinds)];
    all += actuator::Framed(line) + "\n";
    expected.push_back(answer);
  }
  const std::size_t from = rig_->Serial().size();
  rig_->SendPlain(all);
  RunUntilAnswered();
  const std::vector<std::string> answers = AnswersSince(from);
  ASSERT_EQ(answers.size(), expected.size()) << rig_->Serial().substr(0, 3000);
  for (std::size_t i = 0; i < answers.size(); ++i) ASSERT_EQ(answers[i], expected[i]) << i;
  EXPECT_EQ(rig_->Receiver().Lost(), 0u);
  EXPECT_LT(rig_->LongestBlocked_us(), 50) << "the budget of board.c";
  EXPECT_LT(rig_->LongestTurn_us(), kLongestTurn_us) << "the budget of board.c";
  EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));
  ExpectStill();
  std::printf("%d lines: interrupts blocked for %.0f us, a byte waited %.0f us, a turn took %.0f us at most\n", count,
              rig_->LongestBlocked_us(), rig_->Receiver().LongestWait_us(), rig_->LongestTurn_us());
}

// What takes longest to say, in one write: neither the program nor its host is made to wait for it.
TEST_F(FirmwareSerialTest, LongAnswersInOneWriteDoNotEndInAReset) {
  for (int i = 0; i < 16; ++i) {  // a full log
    rig_->PullWire(true, true), rig_->PullWire(false, true);
    ASSERT_TRUE(rig_->RunUntil("ALARM:2\n", 0.2)) << rig_->Serial();
    rig_->PullWire(true, false), rig_->PullWire(false, false);
    rig_->Run(0.05);
    ASSERT_TRUE(Asks("reset", "ok"));
  }
  Start();
  const std::string faults = "faults\n", headers = "header\nheader\nheader\nheader\n";
  for (const std::string& lines :
       {faults + faults + faults + faults + faults, headers + headers + "who\n", faults + headers}) {
    const std::size_t from = rig_->Serial().size();
    rig_->SendPlain(lines);
    rig_->Run(0.05);
    rig_->SendPlain("who\n?");
    rig_->Run(0.4);
    EXPECT_THAT(rig_->Serial().substr(from), Not(HasSubstr("watchdog")));
    EXPECT_EQ(AnswersSince(from).size(), std::ranges::count(lines, '\n') - (lines.ends_with("who\n") ? 1 : 0)) << lines;
    EXPECT_GT(rig_->Samples().back().duty, 0) << "the program goes on";
  }
}

// While it runs each stop is one.
TEST_F(FirmwareSerialTest, RunAndStopInOneWriteDoNotMove) {
  ASSERT_TRUE(Asks("zero", "ok"));
  const double stroke = rig_->Stroke();
  const std::size_t from = rig_->Serial().size();
  rig_->SendPlain(actuator::Framed("run") + "\n" + actuator::Framed("stop") + "\n");
  rig_->Run(0.5);
  EXPECT_EQ(AnswersSince(from), (std::vector<std::string>{"ok", "ok"}));
  EXPECT_EQ(rig_->Samples().back().duty, 0);
  EXPECT_NEAR(rig_->Stroke(), stroke, 0.01);
}

TEST_F(FirmwareSerialTest, JogsBackToBackRunAsTheyWereAsked) {
  for (int i = 0; i < 20; ++i) {
    const double from = rig_->Time();
    rig_->SendPlain(actuator::Framed("jog -300 40") + "\n" + actuator::Framed("alive") + "\n");
    rig_->Run(0.25);
    double driven = 0;
    for (const RigSample& sample : rig_->Samples()) {
      if (sample.time_s <= from || sample.duty == 0) continue;
      ASSERT_LT(sample.duty, 0) << "the way that was asked for";
      ASSERT_GE(sample.duty, -0.3 - 1e-9) << "not faster";
      ++driven;
    }
    EXPECT_NEAR(driven, 40, 2) << i;
  }
}

// `home` in several pieces, Ctrl-X or a hold between: nothing of it is left.
TEST_F(FirmwareSerialTest, WhatCameBeforeAnAbortOrAHoldIsForgotten) {
  const std::string home = actuator::Framed("home");
  for (const char c : {'\x18', '!'}) {
    for (std::size_t cut = 0; cut <= home.size(); ++cut)
      rig_->SendPlain(home.substr(0, cut) + c + "\n"), rig_->Run(0.01);
    rig_->SendPlain(home + "\n" + c), rig_->Run(0.1);
    rig_->SendPlain(actuator::Framed("jog 300 500") + "\n" + home + "\n" + home + "\n" + c), rig_->Run(0.2);
  }
  // What has begun before the character came is braked at once; nothing begins after it.
  const std::size_t until = rig_->Samples().size();
  rig_->Run(0.5);
  for (std::size_t i = until; i < rig_->Samples().size(); ++i) ASSERT_EQ(rig_->Samples()[i].duty, 0);
  EXPECT_LE(DriveTimeAfter(0.1), rig_->Time());
  EXPECT_THAT(rig_->Serial(), Not(HasSubstr("<homing")));
  double moved = 0;
  for (const RigSample& sample : rig_->Samples()) moved = std::max(moved, std::abs(sample.stroke_mm - 300));
  EXPECT_LT(moved, 0.05) << "a line that was whole before the character may drive for the ms between";
}

// Noise, plain text and lines of another program: a million bytes with LAKE_LONG_TESTS=1 in the environment.
TEST_F(FirmwareSerialTest, RandomBytesStartNothing) {
  ZeroAndRun();
  rig_->Run(0.3);
  rig_->SendNow('!');
  rig_->Run(0.5);
  const double stroke = rig_->Stroke();
  const std::size_t from = rig_->Samples().size();
  const int count = std::getenv("LAKE_LONG_TESTS") ? 1'000'000 : 20'000;
  std::mt19937 random(7);
  const char* words[] = {"home\n", "run\n", "~", "stop\n", "jog 500 1000\n", "run*", "\n", "home*0000\n", "zero\n"};
  for (int sent = 0; sent < count;) {
    std::string bytes;
    for (int i = 0; i < 200; ++i) {
      if (random() % 20 == 0)
        bytes += words[random() % std::size(words)];
      else
        bytes += static_cast<char>(random() % 256);
    }
    sent += static_cast<int>(bytes.size());
    rig_->SendPlain(bytes);
    while (rig_->Receiver().Waiting() > 0) rig_->Run(0.01);
  }
  rig_->Run(0.2);
  for (std::size_t i = from; i < rig_->Samples().size(); ++i) ASSERT_EQ(rig_->Samples()[i].duty, 0);
  EXPECT_NEAR(rig_->Stroke(), stroke, 1e-6);
  EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));
  rig_->SendPlain("\n");
  EXPECT_TRUE(Asks("stop", "ok")) << "and it still hears";
}

// Both ends have the same check sum; the value is the one that catalogues of CRCs give for these nine digits.
TEST(SerialFrame, IsTheCataloguesCrc) {
  EXPECT_EQ(actuator::Framed("123456789"), "123456789*6F91");
  EXPECT_EQ(actuator::Unframed("123456789*6F91"), "123456789");
  for (const char* wrong :
       {"123456789", "123456789*6f91", "123456789*6F92", "12345678*6F91", "", "*", "123456789*6F91 "})
    EXPECT_EQ(actuator::Unframed(wrong), std::nullopt) << wrong;
}

}  // namespace
}  // namespace lake
