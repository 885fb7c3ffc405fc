#include "controller.h"

#include "analog.h"
#include "board.h"
#include "config.h"
#include "end_stops.h"
#include "motor.h"
#include "plant.h"
#include "portable.h"
#include "power.h"
#include "program.h"

static volatile uint8_t hold_asked, abort_asked;  // by an interrupt
static uint32_t time_ms;
static motion_t jog;
static uint8_t is_heard;
static uint16_t silent_ms;

static reply_t take_jog(int16_t request_counts, uint16_t request_ms) {
  const int8_t direction = request_counts < 0 ? -1 : 1;
  const uint16_t counts = direction * request_counts;
  if (!program_is_measured(direction, counts)) return REPLY_BAD_NUMBER;
  if (state_end_stop_ahead(direction)) return REPLY_STOP_AHEAD;
  if (program_soft_limit_ahead(direction)) return REPLY_LIMIT_AHEAD;
  jog = program_jog(direction, counts);
  if (machine.knowledge == STROKE_AT_START) machine.knowledge = STROKE_ESTIMATED;
  machine.end_ms = request_ms;
  return REPLY_OK;
}

static void reset(void) {
  program_reset();
  state_on(ON_RESET);
  machine.fault = FAULT_NONE;
  machine.knowledge = STROKE_UNKNOWN;
  motor_forgive();
  power_forgive();
}

// What is to move begins with its checks, unless it was refused or has found a fault.
static reply_t begin(event_t event, reply_t reply) {
  if (reply == REPLY_OK) state_on(event);
  return reply;
}

static reply_t answer(request_t request, int16_t jog_counts, uint16_t jog_ms) {
  const uint8_t moves = request == REQUEST_RUN || request == REQUEST_HOME || request == REQUEST_JOG;
  if (machine.state != STATE_IDLE && (moves || request == REQUEST_ZERO)) return REPLY_STATE;
  if (moves && end_stops_button_is_released()) return REPLY_BUTTON;
  switch (request) {
    case REQUEST_RUN:
      return begin(ON_RUN, program_take_run());
    case REQUEST_HOME:
      return begin(ON_HOME, program_take_home());
    case REQUEST_ZERO:
      return program_take_zero();
    case REQUEST_JOG:
      return begin(ON_JOG, take_jog(jog_counts, jog_ms));
    case REQUEST_STOP:
      state_on(ON_STOP);
      return REPLY_OK;
    case REQUEST_RESET:
      reset();
      return REPLY_OK;
  }
  return REPLY_UNKNOWN;
}

static uint8_t take(volatile uint8_t* flag) {
  const uint8_t was = *flag;
  if (was) *flag = 0;
  return was;
}

static void take_realtime(void) {
  if (take(&hold_asked)) state_on(ON_HOLD);
  if (!take(&abort_asked)) return;
  state_on(ON_STOP);
  machine.knowledge = STROKE_UNKNOWN;
}

static void let_go(uint8_t news) {
  machine.news |= news;
  state_on(ON_LET_GO);
}

static void watch_host(void) {
  if (is_heard || !state_is_in(STATES_MOVING))
    silent_ms = 0;
  else if (LAKE_COMMAND_TIMEOUT_MS > 0 && ++silent_ms >= LAKE_COMMAND_TIMEOUT_MS)
    let_go(NEWS_TIMEOUT);
  is_heard = 0;
  if (end_stops_button_is_released() && state_is_in(STATES_MOVING)) let_go(NEWS_BUTTON);
}

// End stops that cannot be pressed as they are, told where nothing moves: is_allowed sees to it while something does.
static void watch_wires(void) {
  static uint8_t wrong_ms;
  const uint8_t both = end_stops_pressed() == (END_STOP_RETRACT | END_STOP_EXTEND);
  if (!state_is_in(STATES_OF(STATE_IDLE) | STATES_OF(STATE_HOLD)) || !(both || program_stop_contradicts_stroke())) {
    wrong_ms = 0;
  } else if (++wrong_ms >= WIRE_WRONG_MS) {
    wrong_ms = 0;
    state_fault(both ? FAULT_BOTH_STOPS : FAULT_STUCK);
  }
}

static void watch_inputs(void) {
  if (board_is_late()) state_fault(FAULT_LATE);
  if (motor_bridge_is_wrong() || power_fault() == POWER_BRIDGE) state_fault(FAULT_BRIDGE);
  if (power_fault() == POWER_RELAY) state_fault(FAULT_RELAY);
  const uint8_t wrong = analog_faults();
  if (wrong == 0) return;
  state_fault(wrong & ANALOG_NO_SUPPLY       ? FAULT_SUPPLY
              : wrong & ANALOG_NO_WIPER      ? FAULT_WIPER
              : wrong & ANALOG_NO_INRUSH     ? FAULT_NO_CURRENT
              : wrong & ANALOG_STRAY_CURRENT ? FAULT_BRIDGE
                                             : FAULT_OVERCURRENT);
}

// What nothing but turns and requests change is as the last one left it; the fault stays, whatever else has changed.
static uint8_t is_kept(kept_t what) {
  kept_begin();
  return state_kept(what) & motor_kept(what) & program_kept(what) & kept_pass(&jog, sizeof jog, what);
}

static void watch_memory(void) {
  if (is_kept(KEPT_COMPARE)) return;
  motor_stop();
  machine.state = STATE_IDLE;
  machine.fault = FAULT_NONE;
  state_fault(FAULT_MEMORY);
}

static motion_t jogging(void) {
  if (machine.clock_ms >= machine.end_ms) {
    state_finish(machine.knowledge);
    return motion_rest();
  }
  if (state_end_stop_ahead(jog.direction) || program_soft_limit_ahead(jog.direction)) {
    state_on(ON_DONE);
    machine.news |= NEWS_JOG_LIMIT;
    return motion_rest();
  }
  return program_careful(jog);
}

static motion_t wanted(void) {
  if (!power_is_ready()) return motion_rest();
  switch (machine.state) {
    case STATE_RUNNING:
      return program_run();
    case STATE_JOGGING:
      return jogging();
    default:
      return program_home();
  }
}

// The last word before the motor.
static uint8_t is_allowed(const motion_t* motion) {
  if (motion->direction == 0) return 1;
  if (end_stops_pressed() == (END_STOP_RETRACT | END_STOP_EXTEND))
    state_fault(FAULT_BOTH_STOPS);
  else if (state_end_stop_ahead(motion->direction))
    state_fault(FAULT_STOP);
  else if (program_stop_is_stuck())
    state_fault(FAULT_STUCK);
  else if (machine.state != STATE_JOGGING && program_hard_limit_ahead(motion->direction))
    state_fault(FAULT_SOFT_LIMIT);
  return machine.state != STATE_FAULT;
}

// What the bridge does now, and so the estimate.
static void keep_books(const motion_t* motion) {
  if (!plant_waits(motion)) ++machine.clock_ms;
  const motion_t rest = motion_rest();
  program_keep_books(motor_direction() == 0 ? &rest : motion, motion);
}

// Places of what outlives a reset: the fault, where the log goes on, the log.
#define PLACE_FAULT 0
#define PLACE_NEXT 1
#define PLACE_LOG 2
#define LOGGED_BYTES 4

void controller_init(void) {
  time_ms = 0;
  machine.before_fault = STATE_IDLE;
  program_init();
  reset();
  const uint8_t latched = board_remembered(PLACE_FAULT);
  if (latched != FAULT_NONE) state_fault((fault_t)latched);
  machine.news = 0;
  hold_asked = 0;
  abort_asked = 0;
  is_heard = 0;
  is_kept(KEPT_COPY);
}

void controller_turn(void) {
  ++time_ms;
  watch_memory();
  end_stops_turn();
  analog_tick(motor_counts());
  take_realtime();
  watch_host();
  watch_wires();
  watch_inputs();
  power_tick(state_is_in(STATES_MOVING), machine.state == STATE_FAULT);
  if (state_is_in(STATES_CHECKING) && power_is_ready()) state_on(ON_READY);
  motion_t motion = wanted();
  if (!is_allowed(&motion)) motion = motion_rest();
  motor_tick(motion.direction, analog_at_supply(motion.counts));
  keep_books(&motion);
  is_kept(KEPT_COPY);
}

reply_t controller_ask(request_t request, int16_t jog_counts, uint16_t jog_ms) {
  is_heard = 1;
  if (hold_asked || abort_asked) return REPLY_STATE;
  watch_memory();
  const reply_t reply = answer(request, jog_counts, jog_ms);
  is_kept(KEPT_COPY);
  return reply;
}

void controller_remember(void) {
  static uint8_t entry[LOGGED_BYTES], next, left;  // of a log's entry
  if (!board_can_remember()) return;
  if (left > 1) {
    --left;
    board_remember(PLACE_LOG + LOGGED_BYTES * next + left - 1, entry[left - 1]);
  } else if (left == 1) {
    left = 0;
    board_remember(PLACE_NEXT, (uint8_t)(next + 1) % LOGGED_MOST);
  } else if (board_remembered(PLACE_FAULT) != machine.fault) {
    const uint16_t time_s = (uint16_t)(time_ms / 1000);
    next = board_remembered(PLACE_NEXT) % LOGGED_MOST;
    board_remember(PLACE_FAULT, (uint8_t)machine.fault);
    if (machine.fault == FAULT_NONE) return;
    entry[0] = (uint8_t)machine.fault;
    entry[1] = (uint8_t)machine.before_fault;
    entry[2] = (uint8_t)time_s;
    entry[3] = (uint8_t)(time_s >> 8);
    left = LOGGED_BYTES + 1;
  }
}

uint8_t controller_logged(uint8_t which, logged_t* logged) {
  const uint8_t next = board_remembered(PLACE_NEXT) % LOGGED_MOST;
  const uint8_t place = PLACE_LOG + LOGGED_BYTES * ((uint8_t)(next + LOGGED_MOST - 1 - which) % LOGGED_MOST);
  logged->fault = board_remembered(place);
  logged->state = board_remembered(place + 1);
  logged->time_s = (uint16_t)(board_remembered(place + 2) | board_remembered(place + 3) << 8);
  return which < LOGGED_MOST && logged->fault != FAULT_NONE;
}

void controller_hold(void) {
  hold_asked = 1;
}
void controller_abort(void) {
  abort_asked = 1;
}
void controller_heard(void) {
  is_heard = 1;
}

status_t controller_status(void) {
  const status_t now = {time_ms,
                        plant_planned_um(),
                        plant_drift_um(),
                        analog_stroke_um(),
                        analog_current_ma(),
                        motor_counts(),
                        motor_direction(),
                        machine.state,
                        machine.fault,
                        machine.before_fault,
                        machine.knowledge,
                        end_stops_pressed()};
  return now;
}

uint32_t controller_time_ms(void) {
  return time_ms;
}

uint8_t controller_take_news(void) {
  const uint8_t taken = machine.news;
  machine.news = 0;
  return taken;
}
