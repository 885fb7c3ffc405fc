// A broken wire of an end stop reads as pressed wherever the actuator is. Each wire, in each state.
#include <fmt/format.h>

#include "host/host_fixture.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

class BrokenWiresTest : public HostFirmwareTest {
 protected:
  // A program from 300 mm on, the end stop so far below it.
  void BuildAbove(double home_mm) {
    firmware_options_.home_stroke_mm = 300 - home_mm;
    Build(FreeDesign({{0, 300}, {2, 306}, {3, 303}}));
    rig_->SetStroke(304);
  }
  void RunUntilDuty(int sign, double most_s = 10) {
    for (double t = 0; t < most_s && rig_->Duty() * sign <= 0; t += 1e-3) rig_->Run(1e-3);
    ASSERT_GT(rig_->Duty() * sign, 0) << rig_->Serial();
  }
};

constexpr double kBesidesTheStart_mm[] = {0, 0.5, 1, 1.9, 2, 2.1, 5};

TEST_F(BrokenWiresTest, HomingFindsAStartAtAnyDistanceFromTheEndStop) {
  for (const double home_mm : kBesidesTheStart_mm) {
    BuildAbove(home_mm);
    ASSERT_TRUE(rig_->Asks("home", "ok"));
    ASSERT_TRUE(rig_->RunUntil("[MSG:done]", 12)) << rig_->Serial();
    rig_->Run(0.3);
    // Run-on past the switch (5 mm/s x 11 ms), and what run-ups lose: 20 ms each.
    EXPECT_NEAR(rig_->Stroke(), 300, 0.2) << home_mm;
    EXPECT_TRUE(rig_->Asks("run", "ok")) << home_mm;
    ASSERT_TRUE(rig_->RunUntil("[MSG:done]", 6)) << rig_->Serial();
    const auto [stroke, drift] = SaidStrokeAndDrift();
    EXPECT_LE(std::abs(rig_->Stroke() - stroke), drift) << home_mm;
    const actuator::DriftForecast forecast =
        actuator::ForecastDrift(stroke_table_, schedule_, table_, firmware_options_);
    // It says whole um; 0.5 um for each ms by which the end stop shortens the way back.
    EXPECT_NEAR(drift, forecast.last_drift_mm, 0.003) << home_mm;
  }
}

// The second touch comes up to 2 mm early then: home is only what releases once more.
TEST_F(BrokenWiresTest, ARetractWireThatBreaksBeforeTheSecondTouchIsNotHome) {
  for (const double home_mm : kBesidesTheStart_mm)
    for (const double later_s : {0.0, 0.05, 0.2}) {
      BuildAbove(home_mm);
      ASSERT_TRUE(rig_->Asks("home", "ok"));
      RunUntilDuty(1), RunUntilDuty(-1);  // it has released and comes again
      rig_->Run(later_s);
      const double from = rig_->Stroke();
      rig_->PullWire(true, true);
      ASSERT_TRUE(rig_->RunUntil("ALARM:5\n", 3)) << home_mm << "\n" << rig_->Serial();
      rig_->Run(0.3);
      EXPECT_LE(std::abs(rig_->Stroke() - from), firmware_options_.stop_travel_mm + 0.1);
      EXPECT_THAT(rig_->Serial(), Not(HasSubstr("[MSG:done]")));
      EXPECT_TRUE(rig_->Asks("reset", "ok"));
      EXPECT_TRUE(rig_->Asks("run", "error:5"));
    }
}

}  // namespace
}  // namespace lake
