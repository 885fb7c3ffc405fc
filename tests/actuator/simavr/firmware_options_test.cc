// The UNO's firmware with each combination of options, compiled as a user does and run in simavr.
#include <fmt/format.h>

#include "actuator/combinations.h"
#include "firmware_fixture.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

class FirmwareOptionsTest : public FirmwareTest {
 protected:
  void BuildWith(const Combination& one) {
    firmware_options_ = one.Options();
    actuator_ = SteadyActuator();
    actuator_.has_relay = one.Has(Combination::kRelay);
    Build(FreeDesign({{0, 300}, {1, 303}}), "");
    rig_->KeepTalking(true);
    rig_->Run(0.6);
  }

  void WaitForDrive(int sign) {
    for (int ms = 0; ms < 700 && rig_->Samples().back().duty * sign <= 0; ++ms) rig_->Run(1e-3);
    ASSERT_GT(rig_->Samples().back().duty * sign, 0) << rig_->Serial();
    rig_->Run(0.05);
  }

  bool IsStill() {
    rig_->Run(0.002);
    return rig_->Samples().back().duty == 0;
  }
};

// It drives either way as it is told, stops when it is told and at an end stop, and runs its program to the end.
TEST_F(FirmwareOptionsTest, EachCombinationIsCompiledAndRuns) {
  for (const Combination& one : CombinationsToTry()) {
    SCOPED_TRACE(one.Name());
    BuildWith(one);
    ZeroAndRun();
    WaitForDrive(1);
    ASSERT_TRUE(rig_->RunUntil("[MSG:done]", 3)) << rig_->Serial();
    EXPECT_NEAR(rig_->Stroke(), 303, 0.4) << "the lag";
    rig_->Run(0.2);
    rig_->Send("jog -400 2000");
    WaitForDrive(-1);
    EXPECT_NEAR(rig_->Samples().back().duty, -0.4, 1e-3);
    ASSERT_TRUE(Asks("stop", "ok"));
    EXPECT_TRUE(IsStill());
    rig_->Run(0.3);
    rig_->Send("jog 400 2000");
    WaitForDrive(1);
    EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM")));
    if (one.Has(Combination::kButton)) {
      rig_->ReleaseButton(true);
      EXPECT_TRUE(IsStill());
      ASSERT_TRUE(rig_->RunUntil("[MSG:button released, stopped]", 0.1)) << rig_->Serial();
      EXPECT_TRUE(Asks("jog 400 2000", "error:10"));
      rig_->ReleaseButton(false);
      rig_->Run(0.3);
      rig_->Send("jog 400 2000");
      WaitForDrive(1);
    }
    rig_->PullWire(false, true);
    EXPECT_TRUE(IsStill());
  }
}

}  // namespace
}  // namespace lake
