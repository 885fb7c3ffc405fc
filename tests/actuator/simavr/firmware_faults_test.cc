// The times of SAFETY.md, measured with the compiled firmware and the converter of the data sheet.
#include <fmt/format.h>

#include <cstdlib>
#include <functional>
#include <sstream>

#include "firmware_fixture.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

class FirmwareFaultsTest : public FirmwareTest {
 protected:
  void BuildAndStand(const std::vector<linkage::StrokeProgram::Knot>& knots, double stroke_mm) {
    Build(FreeDesign(knots), "");
    rig_->SetStroke(stroke_mm);
    rig_->Run(0.1);
    rig_->KeepTalking(true);
  }

  // Until the bridge drives that way.
  void RunUntilDuty(int sign) {
    const double until = rig_->Time() + 10;
    do {
      rig_->Run(1e-3);
      ASSERT_LT(rig_->Time(), until) << rig_->Serial();
    } while (rig_->Samples().back().duty * sign <= 0);
  }

  // The time from `since` on until the fault is said; NaN if another is said, or none within 3 s.
  double ToldAfter(double since_s, const std::string& alarm) {
    const std::size_t from = rig_->Serial().size();
    while (rig_->Time() < since_s + 3) {
      rig_->Run(1e-3);
      const std::size_t said = rig_->Serial().find("ALARM:", from);
      if (said == std::string::npos || rig_->Serial().find('\n', said) == std::string::npos) continue;
      return rig_->Serial().compare(said, alarm.size(), alarm) == 0 ? rig_->Time() - since_s : NAN;
    }
    return NAN;
  }
};

const std::vector<linkage::StrokeProgram::Knot> kBothWays = {{0, 303}, {1, 306}, {1.5, 306}, {2.9, 303}};

TEST_F(FirmwareFaultsTest, ALostSupplySenseIsOffWithin30MsInEveryState) {
  struct Case {
    const char* name;
    std::function<void()> reach;
  };
  const auto ask = [&](const char* line) { ASSERT_TRUE(Asks(line, "ok")) << rig_->Serial(); };
  const auto run = [&](double seconds) { ask("zero"), ask("run"), rig_->Run(seconds); };
  const Case cases[] = {
      {"idle", [] {}},
      {"seeking", [&] { ask("home"), RunUntilDuty(-1), rig_->Run(0.1); }},
      {"backing off", [&] { ask("home"), RunUntilDuty(1), rig_->Run(0.05); }},
      {"coming again", [&] { ask("home"), RunUntilDuty(1), RunUntilDuty(-1), rig_->Run(0.05); }},
      {"positioning", [&] { ask("home"), rig_->RunUntil(",positioning,", 10), RunUntilDuty(1); }},
      {"running, up", [&] { run(0.5); }},
      {"running, resting", [&] { run(1.25); }},
      {"running, down", [&] { run(2); }},
      {"hold", [&] { run(0.5), rig_->SendNow('!'), rig_->Run(0.2); }},
      {"jogging, up", [&] { ask("jog 500 3000"), rig_->Run(0.4); }},
      {"jogging, down", [&] { ask("jog -500 3000"), rig_->Run(0.4); }},
  };
  double longest_s = 0;
  for (const bool everything : {false, true}) {
    firmware_options_.supply_v = 12, home_below_start_mm_ = 5;
    if (everything) WireSensors(firmware_options_);
    for (const Case& one : cases) {
      BuildAndStand(kBothWays, 303);
      one.reach();
      ASSERT_THAT(rig_->Serial(), Not(HasSubstr("ALARM"))) << one.name;
      const double since = rig_->Time();
      rig_->Breaks().supply_wire = true;
      const double told_s = ToldAfter(since, "ALARM:6\n");
      EXPECT_LE(told_s, 0.03) << one.name << (everything ? ", everything wired\n" : "\n") << rig_->Serial();
      EXPECT_LE(DriveTimeAfter(since), 0.03) << one.name;
      rig_->Run(0.2);
      EXPECT_EQ(rig_->Samples().back().duty, 0) << one.name;
      longest_s = std::max(longest_s, told_s);
    }
  }
  std::printf("lost supply sense, 22 cases: told after %.1f ms at most\n", 1e3 * longest_s);
}

// With everything wired, while it extends at 3 mm/s and retracts at 2.14.
TEST_F(FirmwareFaultsTest, WhateverBreaksWhileItRunsIsOffInTheTimeOfSafetyMd) {
  struct Break {
    const char* name;
    std::function<void(AvrRig&)> act;
    const char* alarm;
    double most_s;
  };
  using Wiper = RigBreaks::Wiper;
  const Break breaks[] = {
      {"supply off", [](AvrRig& rig) { rig.Breaks().supply_wire = true; }, "ALARM:6\n", 0.03},
      {"wiper lost", [](AvrRig& rig) { rig.Breaks().wiper = Wiper::kLost; }, "ALARM:7\n", 0.02},
      {"wiper shorted", [](AvrRig& rig) { rig.Breaks().wiper = Wiper::kShorted; }, "ALARM:7\n", 0.02},
      {"wiper frozen", [](AvrRig& rig) { rig.Breaks().wiper = Wiper::kFrozen; }, "ALARM:", 1.5},
      {"rod blocked", [](AvrRig& rig) { rig.Breaks().is_blocked = true; }, "ALARM:", 1.5},
      {"motor reversed", [](AvrRig& rig) { rig.Breaks().is_reversed = true; }, "ALARM:", 0.5},
      {"runs away", [](AvrRig& rig) { rig.Breaks().runs_away_mm_s = 12; }, "ALARM:", 0.26},
      {"short", [](AvrRig& rig) { rig.Actuator().idle_a = 6; }, "ALARM:12\n", 0.03},
      {"stall current", [](AvrRig& rig) { rig.Actuator().idle_a = 2.5; }, "ALARM:12\n", 0.35},
      {"unplugged", [](AvrRig& rig) { rig.Actuator().idle_a = 0, rig.Breaks().is_blocked = true; }, "ALARM:13\n", 0.35},
      {"current wire lost", [](AvrRig& rig) { rig.Breaks().current_wire = true; }, "ALARM:12\n", 0.03},
  };
  WireSensors(firmware_options_);
  for (const Break& one : breaks) {
    double longest_s = 0;
    for (const double moment_s : {0.4, 2.0}) {
      BuildAndStand({{0, 303}, {1.5, 307.5}, {1.7, 307.5}, {3.8, 303}}, 303);
      ZeroAndRun();
      rig_->Run(moment_s);
      ASSERT_THAT(rig_->Serial(), Not(HasSubstr("ALARM"))) << one.name;
      const double since = rig_->Time();
      one.act(*rig_);
      ASSERT_LE(ToldAfter(since, one.alarm), one.most_s) << one.name << "\n" << rig_->Serial();
      const double driven_s = DriveTimeAfter(since);
      EXPECT_LE(driven_s, one.most_s) << one.name;
      rig_->Run(0.2);
      EXPECT_EQ(rig_->Samples().back().duty, 0) << one.name;
      longest_s = std::max(longest_s, driven_s);
    }
    std::printf("%-18s off after %5.1f ms at most\n", one.name, 1e3 * longest_s);
  }
}

// The outputs of a bridge that drives by itself, or whose wires are broken, are seen in the PWM's high and low parts;
// the relay opens. From 96 % of duty on there is no low part to be seen, and what drives the same way adds next to
// nothing.
TEST_F(FirmwareFaultsTest, ABridgeThatDoesNotFollowThePwmIsSwitchedOff) {
  WireSensors(firmware_options_);
  firmware_options_.bridge_sense = true, firmware_options_.pins.safety_relay = 5;
  actuator_.has_relay = true;
  struct Case {
    const char* jog;
    int shorted;
    Wire ena, in1, in2;
    bool is_told;
  };
  using enum Wire;
  const Case cases[] = {
      {"jog 300 2000", 0, kWhole, kWhole, kWhole, false},  {"jog -300 2000", 0, kWhole, kWhole, kWhole, false},
      {"jog 50 2000", 0, kWhole, kWhole, kWhole, false},   {"jog 980 600", 0, kWhole, kWhole, kWhole, false},
      {"jog 1000 600", 0, kWhole, kWhole, kWhole, false},  {"jog 300 2000", 1, kWhole, kWhole, kWhole, true},
      {"jog -300 2000", -1, kWhole, kWhole, kWhole, true}, {"jog 300 2000", -1, kWhole, kWhole, kWhole, true},
      {"jog -1000 900", 1, kWhole, kWhole, kWhole, true},  {"jog 50 2000", 1, kWhole, kWhole, kWhole, true},
      {"jog 950 600", 1, kWhole, kWhole, kWhole, true},    {"jog 1000 600", 1, kWhole, kWhole, kWhole, false},
      {"jog 300 2000", 0, kFive, kWhole, kWhole, true},    {"jog -300 2000", 0, kOpen, kWhole, kWhole, true},
      {"jog 300 2000", 0, kWhole, kGround, kWhole, true},  {"jog 300 2000", 0, kWhole, kWhole, kFive, true},
      {"jog -300 2000", 0, kWhole, kOpen, kWhole, true},
  };
  double longest_s = 0;
  for (const Case& one : cases) {
    BuildAndStand(kBothWays, 305);
    rig_->Run(0.6);
    ASSERT_TRUE(Asks(one.jog, "ok")) << rig_->Serial();
    RunUntilDuty(one.jog[4] == '-' ? -1 : 1);
    rig_->Run(0.15);
    ASSERT_TRUE(rig_->IsRelayClosed());
    const double since = rig_->Time();
    RigBreaks& breaks = rig_->Breaks();
    breaks.shorted = one.shorted, breaks.ena = one.ena, breaks.in1 = one.in1, breaks.in2 = one.in2;
    rig_->Run(0.1);
    const std::string what = fmt::format("{}, shorted {}, {}{}{}", one.jog, one.shorted, static_cast<int>(one.ena),
                                         static_cast<int>(one.in1), static_cast<int>(one.in2));
    EXPECT_EQ(rig_->IsRelayClosed(), !one.is_told) << what << rig_->Serial();
    EXPECT_LT(rig_->LongestBlocked_us(), 50) << "the budget of board.c";
    if (one.is_told) {
      EXPECT_THAT(rig_->Serial(), HasSubstr("ALARM:15\n")) << what;
      EXPECT_LE(DriveTimeAfter(since), 0.04) << what;
      longest_s = std::max(longest_s, DriveTimeAfter(since));
    } else {
      EXPECT_THAT(rig_->Serial(), Not(HasSubstr("ALARM"))) << what;
    }
  }
  std::printf("a bridge that does not follow: off after %.0f ms at most\n", 1e3 * longest_s);
}

// Bits of the static memory that flip: nothing starts, and what moves is stopped or goes on as planned. Every bit with
// LAKE_LONG_TESTS=1, else some.

class FirmwareMemoryTest : public FirmwareTest {
 protected:
  static constexpr int kFirst = 0x100;  // of the ATmega328P's RAM

  int StaticBytes() {
    const auto file = folder_ / "size";
    EXPECT_EQ(
        std::system(("avr-size '" + elf_.string() + "' | awk 'NR==2 {print $2+$3}' > '" + file.string() + "'").c_str()),
        0);
    return std::atoi(ReadTextFile(file).c_str());
  }

  // Address and size of a static variable; its name may have a suffix of the link-time optimiser.
  std::pair<int, int> PlaceOf(const std::string& name) {
    const auto file = folder_ / "symbols";
    EXPECT_EQ(std::system(("avr-nm -S '" + elf_.string() + "' > '" + file.string() + "'").c_str()), 0);
    std::istringstream symbols(ReadTextFile(file));
    for (std::string address, bytes, kind, symbol; symbols >> address >> bytes >> kind;) {
      if (kind.size() != 1) {  // without a size
        std::getline(symbols, symbol);
        continue;
      }
      symbols >> symbol;
      if ((kind == "b" || kind == "B") && symbol.substr(0, symbol.find('.')) == name)
        return {std::stoi(address, nullptr, 16) & 0xFFFF, std::stoi(bytes, nullptr, 16)};
    }
    ADD_FAILURE() << "no variable " << name;
    return {};
  }

  // Every bit, or one in so many, beginning where the seed says.
  std::vector<int> Bits(int seed) {
    const int bits = 8 * StaticBytes(), step = std::getenv("LAKE_LONG_TESTS") ? 1 : bits / 20;
    std::vector<int> some;
    for (int bit = seed * 7 % step; bit < bits; bit += step) some.push_back(bit);
    return some;
  }
};

TEST_F(FirmwareMemoryTest, ABitThatFlipsAtRestStartsNothing) {
  Build(FreeDesign(kKnots), "");
  for (const int bit : Bits(1)) {
    PowerUp();
    rig_->Run(0.03);
    rig_->FlipBit(kFirst + bit / 8, bit % 8);
    rig_->Run(0.08);
    for (const RigSample& sample : rig_->Samples()) ASSERT_EQ(sample.duty, 0) << "bit " << bit;
  }
}

// Of the state all but its last byte, which whoever tells the news takes.
TEST_F(FirmwareMemoryTest, EachByteThatNothingButTheControllerChangesIsKept) {
  Build(FreeDesign(kKnots), "");
  int bit = 0;
  for (const char* name : {"machine", "m", "jog", "q", "behind"}) {
    const auto [address, bytes] = PlaceOf(name);
    ASSERT_GT(bytes, 8) << name;
    for (int byte = 0; byte < bytes - (address == PlaceOf("machine").first ? 1 : 0); ++byte, bit = (bit + 3) % 8) {
      PowerUp();
      rig_->Run(0.03);
      rig_->FlipBit(address + byte, bit);
      EXPECT_TRUE(rig_->RunUntil("ALARM:17\n", 0.05)) << "byte " << byte << " of " << name << ", bit " << bit;
    }
  }
}

// It stops, or goes on as planned, and obeys a hold; a hang ends by the watchdog after 0.12 s.
TEST_F(FirmwareMemoryTest, ABitThatFlipsInARunDoesNotRunAway) {
  Build(FreeDesign({{0, 300}, {3, 310}}), "");
  for (const int bit : Bits(3)) {
    PowerUp();
    Start();
    rig_->Run(0.1);
    const double from = rig_->Stroke();
    rig_->FlipBit(kFirst + bit / 8, bit % 8);
    rig_->Run(0.03);
    rig_->SendNow('!');
    rig_->Run(0.2);
    EXPECT_EQ(rig_->Samples().back().duty, 0) << "bit " << bit << "\n" << rig_->Serial();
    // 3.3 mm/s for 0.03 s and the run-down; a hang at full speed would be 1.2 mm.
    EXPECT_LT(std::abs(rig_->Stroke() - from), 1.3) << "bit " << bit;
  }
}

}  // namespace
}  // namespace lake
