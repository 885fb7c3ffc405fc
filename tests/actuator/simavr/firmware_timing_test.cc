// The time budget of board.c: rounds of conversions and ticks that end within their ms, interrupts that are let in.
#include <fmt/format.h>

#include <cstdlib>

#include "firmware_fixture.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

class FirmwareTimingTest : public FirmwareTest {
 protected:
  void BuildWithEverythingWired() {
    WireSensors(firmware_options_);
    Build(FreeDesign({{0, 300}, {0.8, 304.8}, {1.6, 307.2}, {2.4, 302}, {2.7, 302}, {3.1, 300}}), "");
    rig_->Run(0.1);
    rig_->KeepTalking(true);
  }
};

// A million ticks with LAKE_LONG_TESTS=1 in the environment, some thousands without, which takes 2 s.
TEST_F(FirmwareTimingTest, NoTickAndNoConversionIsLateWithEverythingWired) {
  BuildWithEverythingWired();
  const std::uint64_t most = std::getenv("LAKE_LONG_TESTS") ? 1'000'000 : 3'000;
  const std::uint64_t conversions = rig_->Adc().Conversions(), ticks = rig_->Ticks();
  while (rig_->Ticks() - ticks < most) {
    ZeroAndRun();
    for (int i = 0; i < 25; ++i) rig_->SendNow('?'), rig_->Run(0.1 + 1e-5 * i);
    ASSERT_TRUE(rig_->RunUntil("[MSG:done]", 3)) << rig_->Serial();
    rig_->Run(0.3);
    ASSERT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));
  }
  // Twelve in each ms; those of the last are not all there.
  EXPECT_NEAR(static_cast<double>(rig_->Adc().Conversions() - conversions),
              12.0 * static_cast<double>(rig_->Ticks() - ticks), 12);
  EXPECT_EQ(rig_->Adc().StartsWhileBusy(), 0u);
  EXPECT_EQ(rig_->Adc().ChannelChangesWhileBusy(), 0u);
  EXPECT_EQ(rig_->Receiver().Lost(), 0u);
  EXPECT_LT(rig_->LongestTurn_us(), kLongestTurn_us) << "the budget of board.c";
  EXPECT_LT(rig_->LongestBlocked_us(), 50) << "the budget of board.c";
  std::printf("%llu ticks: the longest turn %.0f us; interrupts blocked for %.0f us, a byte waited %.0f us at most\n",
              static_cast<unsigned long long>(rig_->Ticks() - ticks), rig_->LongestTurn_us(), rig_->LongestBlocked_us(),
              rig_->Receiver().LongestWait_us());
}

// What it says of stroke, current and supply would be old: off within two ms, in every state a fault.
TEST_F(FirmwareTimingTest, AConverterThatStandsStillIsAFault) {
  for (const bool runs : {true, false}) {
    BuildWithEverythingWired();
    ASSERT_TRUE(Asks("zero", "ok"));
    if (runs) {
      ASSERT_TRUE(Asks("run", "ok"));
      rig_->Run(0.3);
      ASSERT_NE(rig_->Samples().back().duty, 0);
    }
    const double since = rig_->Time();
    rig_->Adc().StandStill();
    ASSERT_TRUE(rig_->RunUntil("ALARM:14\n", 0.1)) << rig_->Serial();
    rig_->Run(0.15);
    EXPECT_LE(DriveTimeAfter(since), 0.003);
    EXPECT_EQ(rig_->Samples().back().duty, 0);
    EXPECT_TRUE(Asks("run", "error:4"));
  }
}

}  // namespace
}  // namespace lake
