// A broken wire of an end stop reads as pressed wherever the actuator is. Each wire, in each state.
#include <algorithm>

#include "host/host_states.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

class BrokenWiresTest : public HostStatesTest {
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
    if (home_mm == 1.9) rig_->SetStroke(300 - home_mm - 0.1), rig_->Run(0.05);  // from the pressed end stop
    Home(12);
    rig_->Run(0.3);
    // Run-on past the switch (5 mm/s x 11 ms), and what run-ups lose: 20 ms each.
    EXPECT_NEAR(rig_->Stroke(), 300, 0.2) << home_mm;
    RunToEnd(6);
    const auto [stroke, drift] = SaidStrokeAndDrift();
    EXPECT_LE(std::abs(rig_->Stroke() - stroke), drift) << home_mm;
    const actuator::DriftForecast forecast = actuator::ForecastDrift(Sketch());
    // It says whole um; 0.5 um for each ms by which the end stop shortens the way back.
    EXPECT_NEAR(drift, forecast.last_drift_mm, 0.003) << home_mm;
  }
}

// The second touch comes up to 2 mm early then: home is only what releases once more.
TEST_F(BrokenWiresTest, ARetractWireThatBreaksBeforeTheSecondTouchIsNotHome) {
  for (const double home_mm : kBesidesTheStart_mm)
    for (const double later_s : {0.0, 0.05, 0.2}) {
      BuildAbove(home_mm);
      ASSERT_TRUE(Asks("home", "ok"));
      RunUntilDuty(1), RunUntilDuty(-1);  // it has released and comes again
      rig_->Run(later_s);
      const double from = rig_->Stroke();
      rig_->PullWire(true, true);
      ASSERT_TRUE(rig_->RunUntil("ALARM:5\n", 3)) << home_mm << "\n" << rig_->Serial();
      rig_->Run(0.3);
      EXPECT_LE(std::abs(rig_->Stroke() - from), firmware_options_.StopTravel() + 0.1);
      EXPECT_THAT(rig_->Serial(), Not(HasSubstr("[MSG:done]")));
      EXPECT_TRUE(Asks("reset", "ok"));
      EXPECT_TRUE(Asks("run", "error:5"));
    }
}

// Every wire in every state: whatever is asked for afterwards, the actuator moves no farther than a stop's travel until
// a fault is told, and then not at all.
enum class CutWire { kRetract, kExtend, kBoth, kSupply };
constexpr CutWire kWires[] = {CutWire::kRetract, CutWire::kExtend, CutWire::kBoth, CutWire::kSupply};
constexpr const char* kWireNames[] = {"retract", "extend", "both", "supply"};

double Way(const HostRig& rig, std::size_t from) {
  double way = 0;
  for (std::size_t i = from; i < rig.Samples().size(); ++i)
    way += std::abs(rig.Samples()[i].stroke_mm - rig.Samples()[i - 1].stroke_mm);
  return way;
}

TEST_F(BrokenWiresTest, EachWireInEachStateEndsInAFault) {
  firmware_options_.supply_v = 12;
  std::vector<std::string> states = States();
  std::ranges::replace(states, kAtLimit, "homing, backing off once more");
  for (const std::string& state : states)
    for (const CutWire wire : kWires) {
      const std::string what = std::string(kWireNames[static_cast<int>(wire)]) + " wire, " + state;
      Reach(state);
      const std::size_t pulled = rig_->Samples().size();
      if (wire == CutWire::kRetract || wire == CutWire::kBoth) rig_->PullWire(true, true);
      if (wire == CutWire::kExtend || wire == CutWire::kBoth) rig_->PullWire(false, true);
      if (wire == CutWire::kSupply) rig_->Breaks().supply_wire = true;
      rig_->Run(0.3);
      // What a user would try.
      for (const char* line : {"stop", "run", "home", "jog 400 800", "jog -400 800", "home", "jog 400 2000"}) {
        if (rig_->Serial().find("ALARM:") != std::string::npos) break;
        rig_->Send(line);
        rig_->RunUntil("ALARM:", 4);
      }
      ASSERT_THAT(rig_->Serial(), HasSubstr("ALARM:")) << what;
      rig_->Run(0.3);
      // Both contradict each other, the supply the firmware's limits: told within 30 ms. A stop that stays pressed
      // costs its travel; 0.35 mm of run-on, twice where it turns round.
      const bool at_once = wire == CutWire::kBoth || wire == CutWire::kSupply;
      EXPECT_LE(Way(*rig_, pulled), at_once ? 0.5 : firmware_options_.StopTravel() + 0.7) << what << "\n"
                                                                                          << rig_->Serial();
      const std::size_t told = rig_->Samples().size();
      for (const char* line : {"run", "home", "jog 400 800", "jog -400 800"}) rig_->Send(line), rig_->Run(0.5);
      EXPECT_LE(Way(*rig_, told), 1e-3) << what;
      EXPECT_FALSE(rig_->IsShorted());
    }
}

// A fault outlives an abort and a reset of the board; only a line with a check sum acknowledges it.
TEST_F(BrokenWiresTest, AFaultIsLatchedUntilItIsAcknowledged) {
  Build(FreeDesign({{0, 300}, {2, 306}}));
  rig_->PullWire(true, true), rig_->PullWire(false, true);
  ASSERT_TRUE(rig_->RunUntil("ALARM:2\n", 0.1));
  rig_->PullWire(true, false), rig_->PullWire(false, false);
  rig_->Run(0.1);
  for (int i = 0; i < 3; ++i) {
    const std::size_t from = rig_->Serial().size();
    if (i == 1) rig_->PowerUp();
    rig_->SendNow('\x18');
    rig_->SendPlain("reset\n");
    rig_->Run(0.1);
    EXPECT_NE(rig_->Serial().find("ALARM:2\n", from), std::string::npos) << "it is told again";
    for (const char* line : {"home", "zero", "run", "jog 300 100"}) EXPECT_TRUE(Asks(line, "error:4")) << line;
  }
  EXPECT_TRUE(Asks("reset", "ok"));
  EXPECT_TRUE(Asks("zero", "ok"));
  rig_->PowerUp();
  rig_->Run(0.1);
  EXPECT_TRUE(Asks("zero", "ok"));
}

// Off at the emergency stop or sagging, the supply is told, and what moves ends; within the tolerance it does not. Open
// loop it is the voltage that sets the speed: more than 10 % off is refused as well, a tenth of a second later.
TEST_F(BrokenWiresTest, TheSupplyIsTold) {
  firmware_options_.supply_v = 12;
  for (const double part : {0.0, 0.55, 0.65, 0.88, 0.92, 1.0, 1.08, 1.12, 1.35, 1.45}) {
    Build(FreeDesign({{0, 300}, {2, 306}}));
    ZeroAndRun();
    rig_->Run(0.5);
    const double since = rig_->Time();
    rig_->Actuator().supply = [part](double) { return part; };
    const bool told = rig_->RunUntil("ALARM:6\n", 1);
    EXPECT_EQ(told, std::abs(part - 1) > 0.1) << part;
    if (told) {
      EXPECT_LE(rig_->Time() - since, std::abs(part - 1) > 0.4 ? 0.03 : 0.12);
    }
  }
}

}  // namespace
}  // namespace lake
