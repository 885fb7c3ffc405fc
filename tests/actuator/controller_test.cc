// The firmware's portable part, compiled as C++: the controller, tick by tick, at any order of events.
#include "controller.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "board.h"
#include "config.h"
#include "divide.h"
#include "end_stops.h"
#include "host_board.h"
#include "lake/actuator/stroke_session.h"
#include "lake/core/atomic_file.h"
#include "model_program.h"
#include "motor.h"
#include "places.h"
#include "power.h"
#include "protocol.h"
#include "serial.h"
#include "state.h"

namespace lake {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

class ControllerTest : public testing::Test {
 protected:
  void SetUp() override {
    host_board = {};
    end_stops_init();
    motor_init();
    power_init();
    controller_init();
    Tick(10);  // the end stops have been seen closed
    controller_take_news();
  }

  void Tick(int times = 1) {
    for (int i = 0; i < times; ++i) board_interrupt(), controller_turn();
  }

  // A host that talks, so that the command time-out does not act.
  void TickTalking(int times) {
    for (int i = 0; i < times; ++i) controller_heard(), Tick();
  }

  reply_t Ask(request_t request, int16_t counts = 0, uint16_t ms = 0) {
    const reply_t reply = controller_ask(request, counts, ms);
    Tick();
    return reply;
  }

  void Start() {
    ASSERT_EQ(Ask(REQUEST_ZERO), REPLY_OK);
    ASSERT_EQ(Ask(REQUEST_RUN), REPLY_OK);
  }
};

TEST_F(ControllerTest, PlanFollowsTheScheduleTickByTick) {
  Start();
  const actuator::StrokeSchedule schedule = HostSchedule();
  // One ms of the program has passed. Half an ms of 5 mm/s, rounding of the table.
  for (int ms = 1; controller_status().state == STATE_RUNNING; ++ms, TickTalking(1)) {
    // Clocks stop while the motor brakes for a reversal; the schedule has a rest there, so none is lost.
    ASSERT_NEAR(controller_status().stroke_um / 1e3, schedule.StrokeAt(ms * 1e-3), 0.006) << ms;
    ASSERT_LT(ms, 5000);
  }
  EXPECT_EQ(controller_take_news(), NEWS_DONE);
  EXPECT_NEAR(controller_status().stroke_um / 1e3, 302.1, 0.002);
  TickTalking(LAKE_DEAD_TIME_MS + 1);
  EXPECT_EQ(host_board.bridge, HOST_OFF);
  EXPECT_FALSE(host_board.shorted);
}

TEST_F(ControllerTest, EndStopAheadActsInTheSameTickAndOnlyInItsDirection) {
  Start();
  host_board.open = END_STOP_RETRACT;  // behind, from the beginning
  TickTalking(5);
  ASSERT_EQ(host_board.bridge, HOST_DRIVE);
  host_board.open = END_STOP_RETRACT | END_STOP_EXTEND;
  TickTalking(1);
  EXPECT_EQ(host_board.bridge, HOST_OFF);
  EXPECT_EQ(controller_take_news(), NEWS_FAULT);
  EXPECT_EQ(controller_status().fault, FAULT_BOTH_STOPS);
  EXPECT_EQ(controller_status().knowledge, STROKE_UNKNOWN);
  host_board.open = END_STOP_EXTEND;
  ASSERT_EQ(Ask(REQUEST_RESET), REPLY_OK);
  TickTalking(LAKE_DEAD_TIME_MS);
  EXPECT_EQ(Ask(REQUEST_JOG, 2000, 100), REPLY_STOP_AHEAD);
  EXPECT_EQ(Ask(REQUEST_JOG, -2000, 100), REPLY_OK);
}

// Away from an end stop that was not pressed nothing can press it but a motor that turns the wrong way, or a broken
// wire.
TEST_F(ControllerTest, AnEndStopBehindThatIsPressedByTheMotionStopsAtOnce) {
  Start();
  TickTalking(100);  // 0.5 mm
  host_board.open = END_STOP_RETRACT;
  TickTalking(2);
  EXPECT_EQ(controller_status().fault, FAULT_STUCK);
  EXPECT_EQ(host_board.bridge, HOST_OFF);
}

// The interrupt alone, before any turn of the main loop: off, and nothing drives before that was taken for a stop.
TEST_F(ControllerTest, TheInterruptStopsTheMotorAtAnEndStopAndWhereTheMainLoopIsLate) {
  for (const bool is_late : {false, true}) {
    SetUp();
    Start();
    TickTalking(100);
    ASSERT_EQ(host_board.bridge, HOST_DRIVE);
    host_board.open = END_STOP_RETRACT;  // behind
    board_interrupt();
    ASSERT_EQ(host_board.bridge, HOST_DRIVE);
    host_board.open = is_late ? 0 : END_STOP_EXTEND;
    host_board.is_late = is_late;
    board_interrupt();
    EXPECT_EQ(host_board.bridge, HOST_OFF);
    EXPECT_EQ(host_board.direction, 0);
    controller_turn();
    EXPECT_EQ(controller_status().fault, is_late ? FAULT_LATE : FAULT_BOTH_STOPS);
    EXPECT_EQ(host_board.bridge, HOST_OFF);
  }
}

// A spike that only the interrupt has seen costs a stop.
TEST_F(ControllerTest, WhatTheInterruptHasCutDrivesAgainAfterTheDeadTime) {
  Start();
  TickTalking(100);
  motor_cut();
  for (int ms = 0; ms < LAKE_DEAD_TIME_MS; ++ms) {
    TickTalking(1);
    ASSERT_EQ(host_board.bridge, HOST_OFF) << ms;
  }
  TickTalking(2);
  EXPECT_EQ(host_board.bridge, HOST_DRIVE);
  EXPECT_EQ(controller_status().fault, FAULT_NONE);
}

// ENA that something holds high is found before the first count of duty.
TEST_F(ControllerTest, AJumperOnEnaIsFoundBeforeAnythingMoves) {
  host_board.enable_is_held = 1;
  Start();
  for (int i = 0; i < 20; ++i) {
    TickTalking(1);
    ASSERT_NE(host_board.bridge, HOST_DRIVE);
  }
  EXPECT_EQ(controller_status().fault, FAULT_BRIDGE);
  EXPECT_EQ(Ask(REQUEST_RESET), REPLY_OK);
  Start();
  TickTalking(5);
  EXPECT_EQ(controller_status().fault, FAULT_BRIDGE) << "it is there still";
}

// Blocks that no interrupt divides are real wherever this is compiled, and end.
TEST_F(ControllerTest, BlocksEnd) {
  Start();
  TickTalking(50);
  protocol_turn();
  EXPECT_EQ(host_board.blocked, 0u);
}

TEST_F(ControllerTest, SilenceStopsWhateverMoves) {
  Start();
  Tick(LAKE_COMMAND_TIMEOUT_MS - 1);
  ASSERT_EQ(controller_status().state, STATE_RUNNING);
  Tick();
  EXPECT_EQ(controller_status().state, STATE_HOLD);
  EXPECT_EQ(host_board.bridge, HOST_OFF);
  EXPECT_EQ(controller_take_news(), NEWS_TIMEOUT);
  Tick(3 * LAKE_COMMAND_TIMEOUT_MS);
  EXPECT_EQ(controller_take_news(), 0) << "told once";
  ASSERT_EQ(Ask(REQUEST_STOP), REPLY_OK);
  ASSERT_EQ(Ask(REQUEST_JOG, 2000, 9000), REPLY_OK);
  Tick(LAKE_COMMAND_TIMEOUT_MS);
  EXPECT_EQ(controller_status().state, STATE_IDLE);
}

TEST_F(ControllerTest, AHoldEndsByAStop) {
  Start();
  TickTalking(200);
  controller_hold();
  TickTalking(300);
  EXPECT_EQ(controller_status().state, STATE_HOLD);
  for (const request_t request : {REQUEST_RUN, REQUEST_HOME, REQUEST_JOG})
    EXPECT_EQ(Ask(request, 2000, 100), REPLY_STATE);
  EXPECT_EQ(Ask(REQUEST_STOP), REPLY_OK);
  EXPECT_EQ(controller_status().state, STATE_IDLE);
  EXPECT_EQ(Ask(REQUEST_RUN), REPLY_POSITION) << "it begins again with homing";
  controller_abort();
  TickTalking(1);
  EXPECT_EQ(controller_status().state, STATE_IDLE);
  EXPECT_EQ(controller_status().knowledge, STROKE_UNKNOWN);
}

// The drift grows with the way, to and fro: a jog ends where plan and drift together reach the linkage's end.
TEST_F(ControllerTest, AJogKeepsTheLimitsWithTheDrift) {
  ASSERT_EQ(Ask(REQUEST_ZERO), REPLY_OK);
  for (int i = 0; i < 12; ++i) {
    for (const int16_t counts : {int16_t{4000}, int16_t{-3500}}) {
      Ask(REQUEST_JOG, counts, 3000);
      TickTalking(3200);
      const status_t now = controller_status();
      // One ms of 9.7 mm/s and its drift, and the lag of the stop.
      ASSERT_LE(now.stroke_um + static_cast<int32_t>(now.drift_um), LAKE_UPPER_END_UM + 11 + 9680 * LAKE_LAG_MS / 1000);
    }
  }
  EXPECT_GT(controller_status().drift_um, 40000u) << "a tenth of the way";
  Ask(REQUEST_JOG, 4000, 9000);
  TickTalking(9200);
  EXPECT_EQ(Ask(REQUEST_JOG, 4000, 100), REPLY_LIMIT_AHEAD);
  EXPECT_EQ(Ask(REQUEST_JOG, -3500, 100), REPLY_OK) << "back is allowed";
}

// Random commands, end stops and silences, a million ticks: the bridge's inputs never turn while it drives, opposite
// directions have the brake between them, an end stop ahead is never driven against.
TEST_F(ControllerTest, NoOrderOfEventsBreaksTheRulesOfTheBridge) {
  std::mt19937 random(7);
  const auto one_in = [&](int n) { return random() % n == 0; };
  int last_direction = 0, undriven_ms = 0;
  std::set<std::pair<state_t, int>> driven;  // in which state, which way
  for (int i = 0; i < 1'000'000; ++i) {
    // Every other 20 s is calm, so that homing and programs are begun and come to their ends, with the end stop where
    // homing expects it.
    const bool calm = i / 20'000 % 2 == 1;
    const int rare = calm ? 20 : 1;
    if (one_in(300 * rare)) {
      const auto request = static_cast<request_t>(random() % (REQUEST_JOG + 1));
      const auto rate = static_cast<int16_t>(static_cast<int>(random() % 8001) - 4000);
      controller_ask(request, rate, static_cast<uint16_t>(random() % 2000));
    }
    if (calm && controller_status().state == STATE_IDLE && one_in(100))
      controller_ask(one_in(2) ? REQUEST_HOME : REQUEST_RUN, 0, 0);
    if (one_in(700 * rare)) controller_hold();
    if (controller_status().state == STATE_HOLD && one_in(300)) controller_ask(REQUEST_STOP, 0, 0);
    if (one_in(3000 * rare)) controller_abort();
    if (one_in(40'000)) {  // power off and on, which takes longer than a brake
      host_board = {}, motor_init(), power_init(), controller_init();
      last_direction = 0;
    }
    if (!one_in(50)) controller_heard();
    if (one_in(400 * rare)) host_board.open = random() % 4;
    if (one_in(100)) host_board.open = 0;
    if (calm && (STATES_HOMING & STATES_OF(controller_status().state))) {
      if (host_board.direction > 0) host_board.open = 0;
      if (host_board.direction < 0 && one_in(150)) host_board.open = END_STOP_RETRACT;
    }
    Tick();
    ASSERT_FALSE(host_board.shorted);
    if (host_board.bridge != HOST_DRIVE) {
      ++undriven_ms;
      continue;
    }
    ASSERT_EQ(std::abs(host_board.direction), 1);
    driven.emplace(controller_status().state, host_board.direction);
    if (host_board.direction == -last_direction) {
      ASSERT_GE(undriven_ms, LAKE_DEAD_TIME_MS) << "at " << i << " ms";
    }
    ASSERT_FALSE(host_board.open & (host_board.direction > 0 ? END_STOP_EXTEND : END_STOP_RETRACT));
    last_direction = host_board.direction, undriven_ms = 0;
  }
  for (const state_t state : {STATE_RUNNING, STATE_JOGGING})
    for (const int direction : {1, -1}) EXPECT_TRUE(driven.contains({state, direction})) << state << " " << direction;
  for (const state_t state : {STATE_BACKING_OFF, STATE_RELEASING, STATE_POSITIONING}) {
    EXPECT_TRUE(driven.contains({state, 1})) << state;
    EXPECT_FALSE(driven.contains({state, -1})) << state;
  }
  for (const state_t state : {STATE_SEEKING, STATE_TOUCHING}) {
    EXPECT_TRUE(driven.contains({state, -1})) << state;
    EXPECT_FALSE(driven.contains({state, 1})) << state;
  }
}

// Texts in, texts out.
class ProtocolTest : public ControllerTest {
 protected:
  std::string Say(const std::string& line) {
    host_board.said_length = 0;
    for (const char c : line) host_board.received[host_board.received_head++] = static_cast<std::uint8_t>(c);
    for (int turn = 0; turn < 10; ++turn) protocol_turn();
    return {host_board.said, host_board.said_length};
  }
};

TEST_F(ProtocolTest, EveryLineHasOneReply) {
  EXPECT_THAT(Say(actuator::Framed("zero") + "\n"), HasSubstr(actuator::Framed("ok")));
  for (const auto& [line, reply] : {std::pair{"run", "ok"},
                                    {"run", "error:4"},
                                    {"nonsense", "error:1"},
                                    {"jog 1", "error:2"},
                                    {"jog 99999999999 1", "error:2"},
                                    {"this line is longer than any that there is", "error:3"},
                                    {"home", "error:4"},
                                    {"stop", "ok"},
                                    {"run", "error:5"}})
    EXPECT_THAT(Say(actuator::Framed(line) + "\n"), HasSubstr(actuator::Framed(reply) + "\n")) << line;
}

TEST_F(ProtocolTest, RealTimeCharactersAreNoPartOfALine) {
  for (int c = 0; c < 256; ++c)
    EXPECT_EQ(serial_realtime(static_cast<char>(c)), c == '?'                ? REALTIME_DONE
                                                     : c == '!' || c == 0x18 ? REALTIME_FORGET
                                                                             : REALTIME_NONE)
        << c;
  const std::string said = Say("");
  EXPECT_THAT(said.substr(0, said.rfind('*')), EndsWith("|duty:0.0000|stops:0>"));
}

TEST(Divide, AThousandthIsTheExactQuotient) {
  std::mt19937 random(1);
  std::uniform_int_distribution<std::int32_t> any(INT32_MIN, INT32_MAX);
  for (int i = 0; i < 100'000; ++i)
    for (const std::int32_t number : {any(random), any(random) / 1000, i}) ASSERT_EQ(thousandth(number), number / 1000);
  for (const std::int32_t number : {INT32_MIN, INT32_MIN + 1, -1000, -999, 0xFFFF, 0x10000, INT32_MAX})
    EXPECT_EQ(thousandth(number), number / 1000) << number;
}

// The firmware's table of states: what holds of it, and its drawing in SAFETY.md, which is made anew by
//   LAKE_DRAW_STATES=1 build/test/bin/lake_actuator_test --gtest_filter='TransitionTest.*'

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
