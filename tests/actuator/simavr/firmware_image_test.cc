// The image itself: size, stack, no floating point, and the same sources as a sketch of the Arduino IDE.
#include <fmt/format.h>

#include <cstdlib>

#include "firmware_fixture.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr int kRamBytes = 2048;  // of the ATmega328P

class FirmwareImageTest : public FirmwareTest {
 protected:
  std::string OutputOf(const std::string& command) {
    const auto file = folder_ / "output";
    EXPECT_EQ(std::system(fmt::format("{} > '{}'", command, file.string()).c_str()), 0) << command;
    return ReadTextFile(file);
  }
};

// What a user uploads: without the simulator's hooks, and within the flash next to the largest table, half of the RAM
// free. Warnings are errors of BuildFirmware.
TEST_F(FirmwareImageTest, FlashRamAndStackFitWithRoom) {
  for (const bool is_all_wired : {false, true}) {
    if (is_all_wired) WireAll(firmware_options_);
    if (is_all_wired) firmware_options_.speed_limit_mm_s = 7;
    Build(FreeDesign(kKnots), "");
    const std::string line = OutputOf(fmt::format("avr-size '{}' | awk 'NR==2 {{print $1+$2, $2+$3}}'", elf_.string()));
    int flash = 0, ram = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%d %d", &flash, &ram), 2);
    const int code = flash - static_cast<int>(Sketch().stroke.segments.size()) * actuator::kSegmentBytes;
    EXPECT_LT(code, actuator::kFirmwareBytes);
    if (is_all_wired)
      rig_->Run(0.2);
    else
      Start();
    for (int i = 0; i < 20; ++i) rig_->Send("jog 1 2 3"), rig_->SendNow('?'), rig_->Run(0.05);
    EXPECT_GT(rig_->DeepestStack(), 20);
    EXPECT_LT(ram + rig_->DeepestStack(), kRamBytes / 2) << "half of the RAM stays free";
    EXPECT_LT(rig_->LongestTurn_us(), kLongestTurn_us);
    EXPECT_TRUE(Asks("hang", "error:1")) << "the simulator's hooks are not in it";
    std::printf("flash %d bytes and %d per segment (of %d), RAM %d bytes and stack %d (of %d), turn %.0f us\n", code,
                actuator::kSegmentBytes, actuator::kFlashBytes, ram, rig_->DeepestStack(), kRamBytes,
                rig_->LongestTurn_us());
  }
}

// Not in the interrupt, which is vector 7, and nowhere else: libgcc's routines for it are not linked.
TEST_F(FirmwareImageTest, NoFloatingPoint) {
  Build(FreeDesign(kKnots), "");
  const std::string symbols = OutputOf(fmt::format("avr-nm '{}'", elf_.string()));
  EXPECT_THAT(symbols, HasSubstr("__vector_7"));
  for (const char* routine : {"__addsf3", "__subsf3", "__mulsf3", "__divsf3", "__fixsfsi", "__floatsisf",
                              "__floatunsisf", "__cmpsf2", "__fp_"})
    EXPECT_THAT(symbols, Not(HasSubstr(routine)));
}

// As the Arduino IDE builds a sketch: its .ino as C++ after #include <Arduino.h>, the other files as they are, with the
// core's own main() and start-up.
TEST_F(FirmwareImageTest, RunsAsAnArduinoSketch) {
  const std::filesystem::path avr = "/usr/share/arduino/hardware/arduino/avr";
  const auto core = avr / "cores/arduino";
  if (!std::filesystem::exists(core / "main.cpp")) GTEST_SKIP() << "arduino-core-avr is not installed";
  Build(FreeDesign(kKnots), "");
  const std::string options = fmt::format(
      "-mmcu=atmega328p -DF_CPU=16000000L -DARDUINO=10819 -DARDUINO_AVR_UNO -DARDUINO_ARCH_AVR -Os "
      "-ffunction-sections -fdata-sections -I{} -I{}",
      core.string(), (avr / "variants/standard").string());
  const std::string gcc = LAKE_AVR_GCC, build = (folder_ / "sketch").string();
  std::filesystem::copy(elf_.parent_path(), build);
  const std::string commands = fmt::format(
      "cd '{0}' && {1} {2} -std=gnu11 -Wall -Wextra -Werror -c *.c && "
      "{1} {2} -std=gnu++11 -Wall -Wextra -Werror -x c++ -include Arduino.h -c lake_stroke.ino -o sketch.o && "
      "{1} {2} -std=gnu++11 -w -c {3}/main.cpp -o core_main.o && {1} {2} -std=gnu11 -w -c {3}/wiring.c {3}/hooks.c && "
      "{1} -mmcu=atmega328p -Os -Wl,--gc-sections *.o -o sketch.elf",
      build, gcc, options, core.string());
  ASSERT_EQ(std::system(commands.c_str()), 0);
  elf_ = folder_ / "sketch/sketch.elf";
  PowerUp();
  Start();
  EXPECT_TRUE(rig_->RunUntil("[MSG:done]", schedule_.Duration() + 1)) << rig_->Serial();
  rig_->Run(0.1);
  // The lags of five changes of speed, as in ClosedLoopStrokeFollowsTheProgram.
  EXPECT_NEAR(rig_->Stroke(), schedule_.knots.back().stroke_mm, 0.2 + 5 * 0.13);
}

// The time budget of board.c: rounds of conversions and ticks that end within their ms, interrupts that are let in.

class FirmwareTimingTest : public FirmwareTest {
 protected:
  void BuildWithEverythingWired() {
    WireSensors(firmware_options_);
    firmware_options_.bridge_sense = true;
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
  EXPECT_GT(rig_->LongestTurn_us(), 30);
  EXPECT_LT(rig_->LongestTurn_us(), kLongestTurn_us) << "the budget of board.c";
  EXPECT_LT(rig_->LongestBlocked_us(), 50) << "the budget of board.c";
  EXPECT_LT(rig_->DeepestStack(), kRamBytes / 4);
  EXPECT_NEAR(rig_->Stroke(), schedule_.knots.back().stroke_mm, 0.4);
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
