// The firmware's portable part for another chip: compiled without a warning for the Cortex-M7 of a Teensy 4, it needs
// nothing beside what board.h, bridge.h, serial.h and portable.h ask of a board, and no floating point.
#include <fmt/format.h>

#include <cstdlib>
#include <set>
#include <sstream>

#include "actuator/compiled_once.h"
#include "host/host_fixture.h"

namespace lake {
namespace {

class PortableArmTest : public HostFirmwareTest {
 protected:
  void SetUp() override {
    if (std::system("command -v arm-none-eabi-gcc > /dev/null") != 0)
      GTEST_SKIP() << "gcc-arm-none-eabi is not installed";
  }

  // What it leaves to others.
  static std::set<std::string> UndefinedIn(const std::string& stroke_table) {
    const std::string command = fmt::format(
        "sh -c 'arm-none-eabi-gcc -mcpu=cortex-m7 -mthumb -std=c99 -Os -Wall -Wextra -Werror -c {} && "
        "arm-none-eabi-ld -r *.o -o portable.elf && arm-none-eabi-nm -u portable.elf > undefined.txt'",
        kPortableSources);
    std::istringstream text(ReadTextFile(CompiledOnce(stroke_table, command, "undefined.txt")));
    std::set<std::string> names;
    for (std::string kind, name; text >> kind >> name;) names.insert(name);
    return names;
  }

  static bool IsOfABoard(const std::string& name) {
    for (const actuator::FirmwareFile& file : actuator::FirmwareSources(actuator::Board::kUno))
      for (const char* header : {"board.h", "bridge.h", "serial.h", "portable.h"})
        if (file.name == header && file.text.find(" " + name + "(") != std::string::npos) return true;
    return false;
  }

  static void ExpectOnlyABoardIsLacking(const std::string& stroke_table) {
    const std::set<std::string> of_the_c_library = {"memcpy", "memmove", "memset", "strchr",
                                                    "strcmp", "strncmp", "strtol"};
    const std::set<std::string> names = UndefinedIn(stroke_table);
    EXPECT_TRUE(names.contains("bridge_drive"));
    for (const std::string& name : names)
      EXPECT_TRUE(of_the_c_library.contains(name) || IsOfABoard(name)) << name << " is of no board";
  }
};

TEST_F(PortableArmTest, OpenLoopNeedsNothingButABoard) {
  Build(FreeDesign({{0, 300}, {2, 306}}));
  ExpectOnlyABoardIsLacking(header_);
}

TEST_F(PortableArmTest, WithEverythingWiredNeedsNothingButABoard) {
  WireAllOfAWornOne();
  Build(FreeDesign({{0, 300}, {3, 315}}));
  ExpectOnlyABoardIsLacking(header_);
}

TEST_F(PortableArmTest, CalibrationNeedsNothingButABoard) {
  ExpectOnlyABoardIsLacking(actuator::CalibrationHeader(firmware_options_, "test"));
}

}  // namespace
}  // namespace lake
