// The firmware's files lie in layers: what a file includes lies below it, so no two include each other in a circle.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "lake/actuator/firmware.h"

namespace lake {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;
using testing::SizeIs;

using Files = std::vector<actuator::FirmwareFile>;

// As in libs/design/actuator/README.md, from the lowest.
const std::vector<std::set<std::string>> kLayers = {{"divide", "kept", "portable"},
                                                    {"stroke_table", "pins"},
                                                    {"config"},
                                                    {"board", "bridge", "serial"},
                                                    {"analog", "end_stops", "motor"},
                                                    {"guard", "power"},
                                                    {"state"},
                                                    {"plant"},
                                                    {"plant_open", "plant_pot", "program"},
                                                    {"controller"},
                                                    {"protocol"},
                                                    {"firmware"},
                                                    {"lake_stroke"}};

// controller.c and controller.h are one module.
std::string ModuleOf(const std::string& file) {
  return file.substr(0, file.find('.'));
}

std::map<std::string, std::set<std::string>> Includes(const Files& files) {
  static const std::regex include("^\\s*#\\s*include\\s*\"([^\"]+)\"");
  std::map<std::string, std::set<std::string>> modules = {{"stroke_table", {"portable"}}};  // made for a design
  for (const actuator::FirmwareFile& file : files) {
    std::istringstream lines(file.text);
    auto& included = modules[ModuleOf(file.name)];
    for (std::string line; std::getline(lines, line);)
      if (std::smatch match; std::regex_search(line, match, include) && ModuleOf(match[1]) != ModuleOf(file.name))
        included.insert(ModuleOf(match[1]));
  }
  return modules;
}

std::size_t LayerOf(const std::string& module) {
  std::size_t layer = 0;
  while (layer < kLayers.size() && !kLayers[layer].contains(module)) ++layer;
  return layer;
}

// "a includes b" for each that does not lie below.
std::vector<std::string> NotBelow(const Files& files) {
  std::vector<std::string> wrong;
  for (const auto& [module, included] : Includes(files))
    for (const std::string& other : included)
      if (LayerOf(module) == kLayers.size() || LayerOf(other) >= LayerOf(module))
        wrong.push_back(module + " includes " + other);
  return wrong;
}

Files With(const std::string& file, const std::string& include) {
  Files files = actuator::FirmwareSources();
  for (actuator::FirmwareFile& f : files)
    if (f.name == file) f.text = "#include \"" + include + "\"\n" + f.text;
  return files;
}

TEST(FirmwareLayers, IncludesGoDown) {
  EXPECT_THAT(NotBelow(actuator::FirmwareSources()), IsEmpty());
  EXPECT_THAT(Includes(actuator::FirmwareSources()), SizeIs(26)) << "every module was read";
  EXPECT_THAT(Includes(actuator::FirmwareSources())["motor"], ElementsAre("bridge", "config", "kept", "portable"));
}

TEST(FirmwareLayers, APlantedCircleIsFound) {
  EXPECT_THAT(NotBelow(With("board.c", "controller.h")), ElementsAre("board includes controller"));
  EXPECT_THAT(NotBelow(With("serial.h", "protocol.h")), ElementsAre("serial includes protocol"));
  EXPECT_THAT(NotBelow(With("end_stops.h", "motor.h")), ElementsAre("end_stops includes motor"));
  EXPECT_THAT(NotBelow(With("motor.c", "nowhere.h")), ElementsAre("motor includes nowhere"));
}

// What an interrupt writes and the main loop reads may be torn where it has more bytes than one. These are the
// functions that touch such a variable, each with whether it is of an interrupt or blocks them. A PC reads such a
// number at once, so no run on it can show a torn one.
std::map<std::string, bool> TouchedByInterrupts(const Files& files) {
  static const std::regex shared("volatile u?int(?:16|32)_t ([a-z_]+)"),
      definition("(?:^|\n)(?:static |inline )*[a-z0-9_]+\\*? \\*?([a-z_]+)\\([^)]*\\) \\{[^\n]*\n"),
      harmless("ATOMICALLY|ATOMIC_BLOCK");
  std::map<std::string, bool> found;
  for (const actuator::FirmwareFile& file : files)
    for (std::sregex_iterator name(file.text.begin(), file.text.end(), shared), end; name != end; ++name)
      for (std::sregex_iterator at(file.text.begin(), file.text.end(), definition); at != end; ++at) {
        const std::string rest = at->suffix(), body = rest.substr(0, rest.find("\n}"));
        if (!std::regex_search(body, std::regex("\\b" + (*name)[1].str() + "\\b"))) continue;
        found[(*at)[1]] = (*at)[1].str().ends_with("_interrupt") || std::regex_search(body, harmless);
      }
  return found;
}

TEST(FirmwareLayers, WhatTheMainLoopSharesWithAnInterruptIsNotTorn) {
  EXPECT_THAT(TouchedByInterrupts(actuator::FirmwareSources()),
              ElementsAre(Pair("analog_interrupt", true), Pair("board_analog", true), Pair("set_zero", true)));
}

// Calls without an include are circles as well: what is called must be declared.
TEST(FirmwareLayers, NoFileDeclaresAnothersFunctions) {
  static const std::regex declaration(
      "^[a-z_0-9]+\\*? "
      "(board|bridge|serial|analog|end_stops|plant|motor|guard|kept|power|state|program|controller|protocol|"
      "firmware)_[a-"
      "z_]+\\(.*\\)"
      ";");
  for (const actuator::FirmwareFile& file : actuator::FirmwareSources()) {
    std::istringstream lines(file.text);
    for (std::string line; std::getline(lines, line);)
      if (std::smatch match; std::regex_search(line, match, declaration)) {
        EXPECT_EQ(file.name, match[1].str() + ".h") << line;
      }
  }
}

#ifndef LAKE_AVR_GCC

// Says so where the tests of simavr/ cannot be built.
TEST(Firmware, RunsInSimulator) {
  GTEST_SKIP() << "avr-gcc, libsimavr-dev or libelf-dev is not installed";
}

#endif

}  // namespace
}  // namespace lake
