// The board layer of a Nucleo-64: compiled for its chip, and run on a model of its registers.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <sstream>

#include "actuator/combinations.h"
#include "actuator/compiled_once.h"
#include "actuator/host/host_fixture.h"
#include "lake/actuator/commissioning.h"
#include "lake/actuator/stroke_session.h"
#include "lake/core/error.h"
#include "nucleo_rig.h"

namespace lake {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::ThrowsMessage;

constexpr int kEnaPin = 9, kIn1Pin = 7, kIn2Pin = 8, kRelayPin = 6;

class NucleoTest : public HostFirmwareTest {
 protected:
  void SetUp() override { firmware_options_.board = actuator::Board::kNucleo; }

  std::string Header() {
    Build(FreeDesign({{0, 300}, {3, 315}}));
    return header_;
  }
  void PowerUp() { nucleo_ = std::make_unique<NucleoRig>(Header()); }

  void WireAll() {
    WireAllOfAWornOne();
    firmware_options_.pins.safety_relay = kRelayPin;
  }
  void TakeBts7960() {
    firmware_options_.bridge = actuator::Bridge::kBts7960;
    firmware_options_.pins.ena = 7;
    firmware_options_.pins.in1 = 9;
    firmware_options_.pins.in2 = 10;
  }

  // Until it drives; whoever asks for a jog is there.
  void Jog(const std::string& line) {
    ASSERT_TRUE(nucleo_->Asks(line, "ok")) << nucleo_->Serial();
    nucleo_->Run(0.3);
  }

  std::unique_ptr<NucleoRig> nucleo_;
};

class NucleoImageTest : public NucleoTest {
 protected:
  void SetUp() override {
    NucleoTest::SetUp();
    if (std::system("command -v arm-none-eabi-gcc > /dev/null") != 0)
      GTEST_SKIP() << "gcc-arm-none-eabi is not installed";
  }

  // As README.txt has it, with warnings as errors; what the binutils say of it.
  static std::string Image(const std::string& stroke_table) {
    return ReadTextFile(CompiledOnce(
        stroke_table,
        "sh -c 'arm-none-eabi-gcc -mcpu=cortex-m4 -mthumb -std=gnu99 -Os --specs=nano.specs -nostartfiles -T nucleo.ld "
        "-Wall -Wextra -Werror -Wl,--fatal-warnings *.c -o lake_stroke.elf && "
        "arm-none-eabi-objcopy -O binary lake_stroke.elf lake_stroke.bin && "
        "(arm-none-eabi-nm lake_stroke.elf; arm-none-eabi-objdump -d lake_stroke.elf; od -A n -t x4 -N 8 "
        "lake_stroke.bin) > told.txt'",
        "told.txt", "", actuator::Board::kNucleo));
  }
};

TEST_F(NucleoImageTest, IsCompiledForTheChip) {
  const std::vector<Combination> combinations = CombinationsToTry();
  std::vector<std::string> tables = {actuator::CalibrationHeader(firmware_options_, "test")};
  tables.reserve(1 + combinations.size());
  for (const Combination& one : combinations) {
    firmware_options_ = one.Options(actuator::Board::kNucleo, kRelayPin);
    tables.push_back(Header());
  }
  for (const std::string& table : tables) {
    const std::string told = Image(table);
    // Where the stack begins, and the reset's handler, as Thumb code.
    std::istringstream vectors(told.substr(told.rfind('\n', told.size() - 2)));
    std::uint32_t stack = 0, reset = 0;
    vectors >> std::hex >> stack >> reset;
    EXPECT_EQ(stack, 0x20010000U);
    EXPECT_THAT(told, HasSubstr(fmt::format("{:08x} T start\n", reset - 1)));
    for (const char* unwanted : {"__aeabi_f", "__aeabi_d", "malloc", "_sbrk"})
      EXPECT_THAT(told, Not(HasSubstr(unwanted)));
  }
}

// A block that no interrupt divides blocks them, and leaves them as they were.
TEST_F(NucleoImageTest, UndividedBlocksBlockInterrupts) {
  const std::string told = Image(Header());
  const std::string block = told.substr(told.find("<portable_block>:"), 200);
  EXPECT_THAT(block, HasSubstr("PRIMASK"));
  EXPECT_THAT(block, HasSubstr("cpsid"));
  EXPECT_THAT(told.substr(told.find("<portable_restore>:"), 200), HasSubstr("PRIMASK"));
}

TEST_F(NucleoTest, ClockTickBaudAndPwmAreAnUnos) {
  PowerUp();
  const std::uint32_t pll = nucleo_->Register(0x40023804), clock = nucleo_->Register(0x40023808);
  EXPECT_EQ(clock & 3, 2U) << "the PLL";
  EXPECT_EQ(clock >> 4 & 15, 8U) << "halved";
  ASSERT_TRUE(pll & 1 << 22) << "of the ST-LINK's crystal";
  const double vco_mhz = 8.0 / (pll & 63) * (pll >> 6 & 511), system_mhz = vco_mhz / (2 * (pll >> 16 & 3) + 2) / 2;
  EXPECT_GE(vco_mhz, 192) << "the F401's least";
  EXPECT_LE(vco_mhz, 432);
  EXPECT_EQ(system_mhz, 16);
  EXPECT_EQ(system_mhz * 1e6 / (nucleo_->Register(0xE000E014) + 1), 1000);
  // A frame of 10 bits bears 5 %, in which the other side has its part.
  EXPECT_NEAR(system_mhz * 1e6 / nucleo_->Register(0x40004408), 115200, 0.01 * 115200);
  EXPECT_EQ(system_mhz * 1e6 / (nucleo_->Register(0x4000042C) + 1), 4000);
}

TEST_F(NucleoTest, IsOffAfterAResetAndGreets) {
  PowerUp();
  nucleo_->Run(0.1);
  EXPECT_THAT(nucleo_->Serial(), HasSubstr("[MSG:lake-stroke]\n"));
  for (const int pin : {kEnaPin, kIn1Pin, kIn2Pin}) {
    EXPECT_TRUE(nucleo_->IsOutput(pin)) << pin;
    EXPECT_FALSE(nucleo_->Level(pin)) << pin;
  }
  EXPECT_THAT(nucleo_->Serial(), Not(HasSubstr("WRONG CHECK SUM")));
  EXPECT_THAT(nucleo_->Wrong(), IsEmpty());
}

TEST_F(NucleoTest, AJogHasItsDutyAndStops) {
  PowerUp();
  for (const int sign : {1, -1}) {
    Jog(fmt::format("jog {} 1000", 400 * sign));
    EXPECT_NEAR(nucleo_->PwmOf(kEnaPin), 0.4, 1.0 / actuator::kPwmPeriod);
    EXPECT_EQ(nucleo_->Level(kIn1Pin), sign > 0);
    EXPECT_EQ(nucleo_->Level(kIn2Pin), sign < 0);
    ASSERT_TRUE(nucleo_->Asks("stop", "ok"));
    nucleo_->Run(0.3);
    for (const int pin : {kEnaPin, kIn1Pin, kIn2Pin}) EXPECT_EQ(nucleo_->PwmOf(pin), 0) << pin;
  }
  Jog("jog 1000 1000");
  EXPECT_EQ(nucleo_->PwmOf(kEnaPin), 1);
  EXPECT_THAT(nucleo_->Wrong(), IsEmpty());
}

TEST_F(NucleoTest, ABts7960HasItsPwmOnTheInputThatDrives) {
  TakeBts7960();
  PowerUp();
  for (const int sign : {1, -1}) {
    Jog(fmt::format("jog {} 1000", 400 * sign));
    EXPECT_TRUE(nucleo_->Level(7)) << "both enables";
    EXPECT_NEAR(nucleo_->PwmOf(9), sign > 0 ? 0.4 : 0, 1e-3);
    EXPECT_NEAR(nucleo_->PwmOf(10), sign < 0 ? 0.4 : 0, 1e-3);
    ASSERT_TRUE(nucleo_->Asks("stop", "ok"));
    nucleo_->Run(0.3);
    for (const int pin : {7, 9, 10}) EXPECT_EQ(nucleo_->PwmOf(pin), 0) << pin;
  }
}

TEST_F(NucleoTest, AnEndStopAheadIsOffWithinTwoTicks) {
  PowerUp();
  for (const auto& [stop, jog] : {std::pair{3, "jog 400 3000"}, std::pair{2, "jog -400 3000"}}) {
    Jog(jog);
    ASSERT_GT(nucleo_->PwmOf(kEnaPin), 0);
    nucleo_->Hold(stop, {});  // pressed or its wire off: only the pull-up is left
    nucleo_->Run(0.002);
    EXPECT_EQ(nucleo_->PwmOf(kEnaPin), 0) << jog;
    nucleo_->Hold(stop, false);
    nucleo_->Run(0.3);
  }
}

TEST_F(NucleoTest, WhatHoldsEnaHighIsNotDrivenAgainst) {
  PowerUp();
  nucleo_->Run(0.1);
  nucleo_->Send("jog 400 1000");
  nucleo_->Hold(kEnaPin, true);
  // Its own level as an output is wired against the jumper only once: until it is looked at.
  EXPECT_TRUE(nucleo_->RunUntil("ALARM:15\n", 0.3)) << nucleo_->Serial();
  EXPECT_TRUE(nucleo_->IsInput(kEnaPin));
  nucleo_->Run(0.2);
  EXPECT_TRUE(nucleo_->IsInput(kEnaPin));
}

// All three in each ms, in readings of an UNO's range; each channel as it was when its conversion began.
TEST_F(NucleoTest, ConvertsAllThatIsWiredInEachMs) {
  WireAll();
  PowerUp();
  nucleo_->SetInput(0, 0.75 * 3.3);
  nucleo_->SetInput(1, 2.5 / 1.5);
  nucleo_->SetInput(4, 0);  // the relay is open
  nucleo_->Run(0.2);
  const int before = nucleo_->Conversions();
  nucleo_->Run(0.1);
  EXPECT_NEAR(nucleo_->Conversions() - before, 100 * 12, 12);
  EXPECT_THAT(nucleo_->Wrong(), IsEmpty());
  EXPECT_TRUE(nucleo_->RunUntil(",idle,767,", 0.2)) << "three quarters of 1023\n" << nucleo_->Serial();
  EXPECT_THAT(nucleo_->Serial(), Not(HasSubstr("ALARM")));
}

TEST_F(NucleoTest, AConverterThatStandsStillIsAFault) {
  PowerUp();
  nucleo_->Run(0.1);
  nucleo_->StopConverter();
  EXPECT_TRUE(nucleo_->RunUntil("ALARM:14\n", 0.1)) << nucleo_->Serial();
}

TEST_F(NucleoTest, TheWatchdogIsFedOncePerMs) {
  PowerUp();
  const int before = nucleo_->WatchdogFeeds();
  nucleo_->Run(0.1);
  EXPECT_NEAR(nucleo_->WatchdogFeeds() - before, 100, 2);
  // Its clock of 17 to 47 kHz, by 4.
  const double counts = nucleo_->Register(0x40003008);
  EXPECT_GT(counts * 4 / 47e3, 0.05);
  EXPECT_LT(counts * 4 / 17e3, 0.16);
}

TEST_F(NucleoTest, OutputsThatDoNotFollowThePwmAreSeen) {
  firmware_options_.bridge_sense = true;
  for (const bool is_stuck : {false, true}) {
    PowerUp();
    nucleo_->WireOutputs();
    Jog("jog 400 2000");
    ASSERT_GT(nucleo_->PwmOf(kEnaPin), 0);
    nucleo_->StickOutput(is_stuck);
    EXPECT_EQ(nucleo_->RunUntil("ALARM:15\n", 0.3), is_stuck) << nucleo_->Serial();
    EXPECT_EQ(nucleo_->PwmOf(kEnaPin) == 0, is_stuck);
  }
}

TEST_F(NucleoTest, AFaultOutlivesAReset) {
  PowerUp();
  for (const int stop : {2, 3}) nucleo_->Hold(stop, {});
  ASSERT_TRUE(nucleo_->RunUntil("ALARM:2\n", 0.2)) << nucleo_->Serial();
  nucleo_->Run(0.01);
  for (const int stop : {2, 3}) nucleo_->Hold(stop, false);
  nucleo_->PowerUp();
  nucleo_->Run(0.2);
  EXPECT_TRUE(nucleo_->Asks("jog 400 100", "error:4")) << nucleo_->Serial();
  EXPECT_TRUE(nucleo_->Asks("reset", "ok"));
  EXPECT_TRUE(nucleo_->Asks("jog 400 100", "ok"));
  EXPECT_THAT(nucleo_->Wrong(), IsEmpty());
}

// Tidied at a start; wherever power is lost in that, at each single step and from either sector into the other, all is
// there after the next start.
TEST_F(NucleoTest, WhatIsKeptOutlivesPowerLostWhileItIsTidied) {
  bool is_tidied = false;
  PowerUp();
  for (int run = 0; !is_tidied; ++run) {
    const int step = 1 + run / 2;
    ASSERT_LT(step, 50);
    for (int i = 0; i < 520; ++i) nucleo_->Remember(static_cast<std::uint8_t>(i % 5), static_cast<std::uint8_t>(i));
    nucleo_->LosePowerAtFlashWork(step);
    const int before = nucleo_->Erasures();
    try {
      nucleo_->PowerUp();
      is_tidied = run % 2 == 1;
    } catch (const PowerLost&) {
    }
    nucleo_->LosePowerAtFlashWork(-1);
    nucleo_->PowerUp();
    for (std::uint8_t place = 0; place < 5; ++place)
      EXPECT_EQ(nucleo_->Remembered(place), static_cast<std::uint8_t>(515 + place)) << "step " << step;
    EXPECT_EQ(nucleo_->Remembered(200), 0);
    EXPECT_GE(nucleo_->Erasures() - before, 1) << "it was tidied";
    EXPECT_THAT(nucleo_->Wrong(), IsEmpty());
  }
}

// Whoever waits for its greeting bears the longest start: many kept numbers, the slowest flash of the data sheets.
TEST_F(NucleoTest, ItGreetsInTimeWhereItTidies) {
  PowerUp();
  for (int i = 0; i < 8000; ++i)
    nucleo_->Remember(static_cast<std::uint8_t>(i % 255), static_cast<std::uint8_t>(i + 1));
  const int before = nucleo_->Erasures();
  nucleo_->PowerUp();
  EXPECT_GT(nucleo_->Erasures(), before) << "it was tidied";
  EXPECT_LT(nucleo_->ErasingSeconds(), 0.5 * actuator::SessionOptions{}.greeting_s);
}

// It drives and stops as it is told, whatever is wired.
TEST_F(NucleoTest, EachCombinationOfOptionsIsCompiledAndRuns) {
  for (const Combination& one : CombinationsToTry()) {
    SCOPED_TRACE(one.Name());
    firmware_options_ = one.Options(actuator::Board::kNucleo, kRelayPin);
    const bool is_bts = one.Has(Combination::kBts7960), has_relay = one.Has(Combination::kRelay);
    PowerUp();
    const auto duty = [&](int driven) { return is_bts && !nucleo_->Level(7) ? 0 : nucleo_->PwmOf(driven); };
    // The supply behind the relay, and half an ampere while the motor is driven.
    const auto run = [&](int driven, int sign, double seconds) {
      for (int left = static_cast<int>(std::lround(1e3 * seconds)); left > 0; --left) {
        nucleo_->SetInput(4, !has_relay || nucleo_->Level(kRelayPin) ? 12 / 7.8 : 0);
        nucleo_->SetInput(1, (2.5 + (duty(driven) > 0 ? 0.5 * sign * 0.185 : 0)) / 1.5);
        nucleo_->Run(1e-3);
      }
    };
    if (one.Has(Combination::kSense)) nucleo_->WireOutputs(is_bts);
    run(kEnaPin, 1, 0.6);
    for (const int sign : {1, -1}) {
      const int driven = is_bts ? (sign > 0 ? 9 : 10) : kEnaPin;
      nucleo_->Send(fmt::format("jog {} 2000", 400 * sign));
      for (int ms = 0; ms < 700 && duty(driven) == 0; ++ms) run(driven, sign, 1e-3);
      run(driven, sign, 0.05);  // the rod stands, which is told once it has been driven for 0.6 mm
      EXPECT_NEAR(duty(driven), 0.4, 1e-3) << nucleo_->Serial();
      nucleo_->Send("stop");
      run(driven, sign, 0.15);
      EXPECT_EQ(duty(driven), 0) << nucleo_->Serial();
    }
    EXPECT_THAT(nucleo_->Serial(), Not(HasSubstr("ALARM")));
    EXPECT_THAT(nucleo_->Wrong(), IsEmpty());
  }
}

TEST_F(NucleoTest, ItsReferenceAndDividersAreInTheTable) {
  WireAll();
  const std::string nucleo = Header();
  // 12 V behind 68 and 10 kOhm, of 3.3 V; 2.5 V of the current sensor behind 10 and 20.
  EXPECT_THAT(nucleo,
              HasSubstr(fmt::format("#define LAKE_SUPPLY_LEAST {}\n", std::lround(0.6 * 12 / 7.8 / 3.3 * 4092))));
  EXPECT_THAT(nucleo, HasSubstr(fmt::format("#define LAKE_CURRENT_ZERO {}\n", std::lround(2.5 / 1.5 / 3.3 * 4092))));
  EXPECT_THAT(nucleo, HasSubstr("// Stroke program for the Nucleo."));
  const std::string schematic = actuator::SchematicSvg(firmware_options_);
  EXPECT_THAT(schematic, HasSubstr("between 3.3 V and GND"));
  EXPECT_THAT(schematic, HasSubstr(">68 kΩ<"));
  EXPECT_THAT(schematic, HasSubstr(">Nucleo<"));
  firmware_options_.pins.safety_relay = 5;
  EXPECT_THAT([&] { firmware_options_.Check(); }, ThrowsMessage<Error>(HasSubstr("a Nucleo pulls D5 up")));
  firmware_options_.pins.safety_relay = kRelayPin;
  firmware_options_.supply_v = 24;
  EXPECT_THAT([&] { firmware_options_.Check(); },
              ThrowsMessage<Error>(HasSubstr("--supply must be 0 or within 4..18.2 V, not 24")));
}

}  // namespace
}  // namespace lake
