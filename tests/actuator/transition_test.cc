// The firmware's table of states: what holds of it, and its drawing in SAFETY.md, which is made anew by
//   LAKE_DRAW_STATES=1 build/test/bin/lake_actuator_test --gtest_filter='TransitionTest.*'
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/atomic_file.h"
#include "places.h"
#include "state.h"

namespace lake {
namespace {

constexpr const char* kNames[] = {"idle",     "seeking",   "positioning",   "running",     "hold",
                                  "jogging",  "fault",     "checking_home", "proving",     "backing_off",
                                  "touching", "releasing", "checking_run",  "checking_jog"};
constexpr const char* kEvents[] = {
    "home",  "run",     "jog",  "stop, Ctrl-X", "reset", "!", "time-out, button released",
    "ready", "pressed", "done", "fault"};
const std::vector<std::pair<std::string, unsigned>> kGroups = {
    {"moving", STATES_MOVING}, {"homing", STATES_HOMING}, {"program", STATES_PROGRAM}, {"jog", STATES_JOG}};

// The states in which an event leads to another.
unsigned From(int event, int to) {
  unsigned from = 0;
  for (int state = 0; state < STATE_COUNT; ++state)
    if (transition(static_cast<state_t>(state), static_cast<event_t>(event)) == to) from |= STATES_OF(state);
  return from;
}

std::string Group(const std::string& name, unsigned states, const std::string& inner = "") {
  std::string text = fmt::format("  state {} {{\n{}", name, inner);
  for (int state = 0; inner.empty() && state < STATE_COUNT; ++state)
    if (states & STATES_OF(state)) text += fmt::format("    {}\n", kNames[state]);
  return text + "  }\n";
}

// An arrow from a group stands for one from each of its states.
std::string Drawing() {
  std::string groups;
  for (const auto& [name, states] : kGroups)
    if (name != "moving") groups += Group(name, states);
  std::string text = "```mermaid\nstateDiagram-v2\n  [*] --> idle\n" + Group("moving", 0, groups);
  for (int event = 0; event < ON_COUNT; ++event)
    for (int to = 0; to < STATE_COUNT; ++to) {
      unsigned from = From(event, to);
      const auto draw = [&](const std::string& name, unsigned states) {
        if ((from & states) != states) return;
        text += fmt::format("  {} --> {}: {}\n", name, kNames[to], kEvents[event]);
        from &= ~states;
      };
      for (const auto& [name, states] : kGroups) draw(name, states);
      for (int state = 0; state < STATE_COUNT; ++state) draw(kNames[state], STATES_OF(state));
    }
  return text + "```\n";
}

TEST(TransitionTest, SafetyMdHasItsDrawing) {
  const auto file = SourceDir() / "libs/design/actuator/SAFETY.md";
  const std::string text = ReadTextFile(file);
  const std::size_t begin = text.find("```mermaid\n"), end = text.find("```\n", begin + 1) + 4;
  ASSERT_NE(begin, std::string::npos);
  if (std::getenv("LAKE_DRAW_STATES"))
    WriteTextFile(file, std::string(text).replace(begin, end - begin, Drawing()));
  else
    EXPECT_EQ(text.substr(begin, end - begin), Drawing());
}

TEST(TransitionTest, WhateverMovesStopsAndNothingLeavesAFaultButAReset) {
  for (int i = 0; i < STATE_COUNT; ++i) {
    const auto state = static_cast<state_t>(i);
    if (STATES_MOVING & STATES_OF(state)) {
      EXPECT_EQ(transition(state, ON_STOP), STATE_IDLE);
      EXPECT_EQ(transition(state, ON_FAULT), STATE_FAULT);
      for (const event_t event : {ON_HOLD, ON_LET_GO})
        EXPECT_TRUE(transition(state, event) == STATE_IDLE || transition(state, event) == STATE_HOLD);
    }
    for (int event = 0; event < ON_COUNT; ++event) {
      const state_t next = transition(state, static_cast<event_t>(event));
      if (next == STATE_COUNT) continue;
      EXPECT_TRUE(state != STATE_FAULT || event == ON_RESET);
      // Nothing moves unless it was asked for at rest and checked.
      if (!(STATES_MOVING & STATES_OF(state)) && (STATES_MOVING & STATES_OF(next))) {
        EXPECT_EQ(state, STATE_IDLE);
        EXPECT_LE(event, ON_JOG);
        EXPECT_TRUE(next == STATE_CHECKING_HOME || next == STATE_CHECKING_RUN || next == STATE_CHECKING_JOG);
      }
    }
  }
}

}  // namespace
}  // namespace lake
