// What somebody with a serial monitor meets.
#include <fmt/format.h>

#include "host/host_fixture.h"

namespace lake {
namespace {

using testing::HasSubstr;

using ByHandTest = HostFirmwareTest;

// Homing is longer than the time-out of a host that does not talk.
TEST_F(ByHandTest, HomingWithoutAHostThatTalksIsHeld) {
  Build(FreeDesign({{0, 300}, {2, 306}}));
  rig_->SetStroke(330);
  rig_->KeepTalking(false);
  ASSERT_TRUE(Asks("home", "ok"));
  EXPECT_FALSE(rig_->RunUntil("[MSG:done]", 4));
  EXPECT_THAT(rig_->Status(), HasSubstr("<hold"));
  EXPECT_EQ(rig_->Duty(), 0);
  EXPECT_TRUE(Asks("home", "error:4"));
  EXPECT_TRUE(Asks("stop", "ok"));
  rig_->KeepTalking(true);
  Home(20);
}

// Whatever moves stops within the ms in which the button is let go, and begins again with homing.
TEST_F(ByHandTest, TheButtonIsHeldWhileAnythingMoves) {
  firmware_options_.pins.hold_button = 4;
  Build(FreeDesign({{0, 300}, {2, 306}}));
  const auto let_go = [&](const char* line, const char* state) {
    ASSERT_TRUE(Asks(line, "ok")) << rig_->Serial();
    rig_->Run(0.3);
    ASSERT_NE(rig_->Duty(), 0) << line;
    const std::size_t from = rig_->Serial().size();
    rig_->ReleaseButton(true);
    rig_->Run(0.001);
    EXPECT_EQ(rig_->Duty(), 0) << line;
    rig_->Run(0.02);
    EXPECT_THAT(rig_->Serial().substr(from), HasSubstr("[MSG:button released, stopped]\n")) << line;
    EXPECT_THAT(rig_->Status(), HasSubstr(state)) << line;
    rig_->ReleaseButton(false);
    rig_->Run(1);
    EXPECT_EQ(rig_->Duty(), 0) << "held again it does not go on";
    ASSERT_TRUE(Asks("stop", "ok"));
  };
  let_go("home", "<hold");
  ASSERT_TRUE(Asks("zero", "ok"));
  let_go("run", "<hold");
  EXPECT_TRUE(Asks("run", "error:5")) << "it begins again with homing";
  let_go("jog 500 2000", "<idle");
  rig_->ReleaseButton(true);
  rig_->Run(0.01);
  for (const char* line : {"home", "jog 500 100"}) EXPECT_TRUE(Asks(line, "error:10")) << line;
  EXPECT_TRUE(Asks("stop", "ok"));
}

TEST_F(ByHandTest, StopGivesHomingUpAndHoldEndsIt) {
  Build(FreeDesign({{0, 300}, {2, 306}}));
  rig_->SetStroke(330);
  rig_->KeepTalking(false);
  ASSERT_TRUE(Asks("home", "ok"));
  rig_->Run(3);
  ASSERT_TRUE(Asks("stop", "ok"));
  rig_->Run(1);
  EXPECT_EQ(rig_->Duty(), 0);
  EXPECT_TRUE(Asks("run", "error:5"));
  ASSERT_TRUE(Asks("home", "ok"));
  rig_->Run(0.5);
  rig_->SendNow('!');
  rig_->Run(0.2);
  EXPECT_THAT(rig_->Status(), HasSubstr("<idle"));
}

TEST_F(ByHandTest, IsToldWhoMayWearItAndWhatTheProgramIs) {
  firmware_options_.design_hash = "0123456789ab";
  Build(FreeDesign({{0, 300}, {2, 306}}));
  rig_->SendNow('\x18');
  rig_->Run(0.1);
  EXPECT_THAT(rig_->Serial(), HasSubstr("[MSG:design 0123456789ab, duty table MODEL, not measured]\n"));
  EXPECT_THAT(rig_->Serial(), HasSubstr("[MSG:open loop: the stroke is planned, not measured]\n"));
  ASSERT_TRUE(Asks("home", "ok"));
  EXPECT_THAT(rig_->Serial(), HasSubstr("[MSG:unworn only: homing takes the knee to "));
}

// Where the curve of speed over duty is steep or bent, near the dead band, the stroke that a jog plans is still the
// largest that its duty can give, and the drift has what it may be less: the limits hold, and the bound holds.

// A table whose speeds rise at once behind the dead band, as those of a screw that breaks loose.
actuator::DutyTable Steep(double dead_band, double speed_mm_s) {
  return actuator::MakeDutyTable({{dead_band, 0, 0},
                                  {dead_band + 0.01, speed_mm_s, speed_mm_s},
                                  {0.6, 2 * speed_mm_s, 2 * speed_mm_s},
                                  {1, 9.7, 9.7}},
                                 "steep");
}

using JogLimitsTest = HostFirmwareTest;

TEST_F(JogLimitsTest, TheBoundHoldsAtEveryDuty) {
  for (const auto& [dead_band, speed] : {std::pair{0.26, 3.0}, {0.21, 4.5}, {0.32, 1.5}}) {
    table_ = Steep(dead_band, speed);
    Build(FreeDesign({{0, 300}, {2, 310}}));
    for (double duty = dead_band - 0.03; duty < 1; duty += duty < dead_band + 0.03 ? 0.002 : 0.05)
      for (const int sign : {1, -1}) {
        ASSERT_TRUE(Asks("zero", "ok")) << rig_->Serial();
        rig_->SetStroke(300);
        rig_->Send(fmt::format("jog {} 3000", sign * std::lround(1000 * duty)));
        ASSERT_TRUE(rig_->RunUntil("[MSG:", 4)) << rig_->Serial();
        rig_->Run(0.3);
        const auto [stroke, drift] = SaidStrokeAndDrift();
        EXPECT_LE(std::abs(rig_->Stroke() - stroke), drift) << "jog at " << sign * duty << ", dead band " << dead_band;
        ASSERT_TRUE(Asks("reset", "ok"));
      }
  }
}

TEST_F(JogLimitsTest, ALongJogKeepsTheSoftLimit) {
  for (const int duty : {262, 265, 270, 275, 280, 300, 320}) {
    table_ = Steep(0.26, 3);
    Build(FreeDesign({{0, 350}, {2, 356}}));  // the upper soft limit is 374.02 mm
    ASSERT_TRUE(Asks("zero", "ok"));
    for (int i = 0; i < 3 && rig_->Serial().find("at a limit") == std::string::npos; ++i) {
      rig_->Send(fmt::format("jog {} 10000", duty));
      ASSERT_TRUE(rig_->RunUntil("[MSG:", 11)) << rig_->Serial();
      rig_->Run(0.2);
    }
    EXPECT_LT(rig_->Stroke(), schedule_.limits.upper_mm) << duty;
    EXPECT_GT(rig_->Stroke(), 355) << duty << ": and does not end at once";
  }
}

// What was not measured is not known to be slow.
TEST_F(JogLimitsTest, ADutyBeyondTheTableIsRefused) {
  table_ = actuator::MakeDutyTable({{0.2, 0, 0}, {0.5, 5, 5}, {0.8, 8, std::nan("")}}, "to 0.8");
  Build(FreeDesign({{0, 300}, {2, 304}}));
  for (const char* line : {"jog 810 100", "jog -510 100", "jog 1000 100"}) EXPECT_TRUE(Asks(line, "error:2")) << line;
  for (const char* line : {"jog 800 100", "jog -500 100"}) {
    EXPECT_TRUE(Asks(line, "ok")) << line;
    rig_->Run(0.3);
  }
}

// A first row that moves says nothing of smaller duties: they may move as fast, or not at all.
TEST_F(JogLimitsTest, BelowAFirstRowThatMovesTheWayIsBounded) {
  table_ = actuator::MakeDutyTable({{0.3, 3, 3}, {1, 9.7, 9.7}}, "moves from its first row on");
  for (const auto& truth : {Steep(0.1, 2), Steep(0.28, 3)}) {
    actuator_.table = &truth;
    Build(FreeDesign({{0, 300}, {2, 310}}));
    ASSERT_TRUE(Asks("zero", "ok"));
    rig_->Send("jog 250 1500");
    ASSERT_TRUE(rig_->RunUntil("[MSG:done]", 4)) << rig_->Serial();
    rig_->Run(0.3);
    const auto [stroke, drift] = SaidStrokeAndDrift();
    EXPECT_LE(std::abs(rig_->Stroke() - stroke), drift);
    // A wire that breaks is found on such a jog as well.
    rig_->PullWire(true, true);
    rig_->Send("jog 250 4000");
    EXPECT_TRUE(rig_->RunUntil("ALARM:5\n", 3)) << rig_->Serial();
  }
}

}  // namespace
}  // namespace lake
