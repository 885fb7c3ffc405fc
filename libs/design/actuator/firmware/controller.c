#include "controller.h"

#include "analog.h"
#include "board.h"
#include "config.h"
#include "end_stops.h"
#include "motor.h"
#include "portable.h"
#include "power.h"
#include "program.h"

// Shared by the tick and the main loop, and by the tick and the interrupts that it lets in: whoever may be interrupted
// by another touches them in ATOMICALLY blocks only, which are barriers.
static status_t told;  // of the last tick
static uint32_t time_ms;
static struct __attribute__((aligned(2))) {  // of an even size: sum_of
  motion_t jog;
} c;
static uint16_t sum_kept;
typedef struct {
  request_t request;
  reply_t reply;  // REPLY_NONE until a tick has it
  int16_t counts;
  uint16_t ms;
} asked_t;
static asked_t asked[REQUESTS_MOST];  // in their order; those with a reply come first
static uint8_t asked_count;
static uint8_t hold_asked, abort_asked, heard;

static uint16_t silent_ms;

static reply_t take_jog(int16_t request_counts, uint16_t request_ms) {
  const int8_t direction = request_counts < 0 ? -1 : 1;
  const uint16_t counts = direction * request_counts;
  if (!program_is_measured(direction, counts)) return REPLY_BAD_NUMBER;
  if (state_end_stop_ahead(direction)) return REPLY_STOP_AHEAD;
  if (program_soft_limit_ahead(direction)) return REPLY_LIMIT_AHEAD;
  c.jog = program_jog(direction, counts);
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

// What was asked before a hold or an abort is not done after it.
static void drop_requests(void) {
  for (uint8_t i = 0; i < asked_count; ++i)
    if (asked[i].reply == REPLY_NONE) asked[i].reply = REPLY_STATE;
}

static void abort_all(void) {
  drop_requests();
  state_on(ON_STOP);
  machine.knowledge = STROKE_UNKNOWN;
}

// What is to move begins with its checks, unless it was refused or has found a fault.
static reply_t begin(event_t event, reply_t reply) {
  if (reply == REPLY_OK) state_on(event);
  return reply;
}

static reply_t answer(const asked_t* what) {
  if (machine.state != STATE_IDLE && what->request != REQUEST_STOP && what->request != REQUEST_RESET)
    return REPLY_STATE;
  switch (what->request) {
    case REQUEST_RUN:
      return begin(ON_RUN, program_take_run());
    case REQUEST_HOME:
      return begin(ON_HOME, program_take_home());
    case REQUEST_ZERO:
      return program_take_zero();
    case REQUEST_JOG:
      return begin(ON_JOG, take_jog(what->counts, what->ms));
    case REQUEST_STOP:
      state_on(ON_STOP);
      return REPLY_OK;
    case REQUEST_RESET:
      reset();
      return REPLY_OK;
    default:
      return REPLY_NONE;
  }
}

static void take_requests(void) {
  for (uint8_t i = 0; i < asked_count; ++i) {
    if (asked[i].reply != REPLY_NONE) continue;
    asked[i].reply = answer(&asked[i]);
    heard = 1;
  }
}

static uint8_t take(uint8_t* flag) {
  uint8_t was;
  ATOMICALLY {
    was = *flag;
    *flag = 0;
  }
  return was;
}

static void take_realtime(void) {
  if (take(&hold_asked)) {
    drop_requests();
    state_on(ON_HOLD);
  }
  if (take(&abort_asked)) abort_all();
}

static uint8_t is_silent(void) {
  return LAKE_COMMAND_TIMEOUT_MS > 0 && silent_ms >= LAKE_COMMAND_TIMEOUT_MS;
}

static void watch_host(void) {
  if (take(&heard) || !state_is_in(STATES_MOVING)) {
    silent_ms = 0;
  } else if (++silent_ms, is_silent()) {
    machine.news |= NEWS_TIMEOUT;
    state_on(ON_SILENCE);
  }
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

// What nothing but the tick changes is as the last tick left it; the fault stays, whatever else has changed.
static uint16_t sum_now(void) {
  return state_sum() ^ motor_sum() ^ program_sum() ^ sum_of(&c, sizeof c);
}

static void watch_memory(void) {
  if (sum_now() == sum_kept && asked_count <= REQUESTS_MOST) return;
  motor_stop();
  asked_count = 0;
  machine.state = STATE_IDLE;
  machine.fault = FAULT_NONE;
  state_fault(FAULT_MEMORY);
}

static motion_t jogging(void) {
  if (machine.clock_ms >= machine.end_ms) {
    state_finish(machine.knowledge);
    return motion_rest();
  }
  if (state_end_stop_ahead(c.jog.direction) || program_soft_limit_ahead(c.jog.direction)) {
    state_on(ON_DONE);
    machine.news |= NEWS_JOG_LIMIT;
    return motion_rest();
  }
  return program_careful(c.jog);
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

// What the bridge does now, and so the estimate. Without feedback a motion's clock stands still until the bridge does
// what it asks for, so that no brake costs stroke; with feedback a program's until the motor has the speed for it.
static void keep_books(const motion_t* motion) {
  const uint8_t follows = LAKE_FEEDBACK && machine.state == STATE_RUNNING;
  const uint8_t waits = follows ? program_waits() : motor_direction() != motion->direction;
  if (!waits) ++machine.clock_ms;
  const motion_t rest = motion_rest();
  program_keep_books(motor_direction() == 0 ? &rest : motion, motion);
}

static void tell(void) {
  const status_t now = {time_ms,
                        program_stroke_um(),
                        program_drift_um(),
                        analog_stroke_um(),
                        analog_current_ma(),
                        motor_counts(),
                        motor_direction(),
                        machine.state,
                        machine.fault,
                        machine.before_fault,
                        machine.knowledge,
                        end_stops_pressed()};
  told = now;
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
  asked_count = 0;
  machine.news = 0;
  const uint8_t latched = board_remembered(PLACE_FAULT);
  if (latched != FAULT_NONE) state_fault((fault_t)latched);
  hold_asked = abort_asked = heard = 0;
  tell();
  sum_kept = sum_now();
}

void controller_tick(void) {
  ++time_ms;
  watch_memory();
  end_stops_tick();
  analog_tick(motor_counts());
  take_realtime();
  take_requests();
  watch_host();
  watch_wires();
  watch_inputs();
  power_tick(state_is_in(STATES_MOVING), machine.state == STATE_FAULT);
  if (state_is_in(STATES_CHECKING) && power_is_ready()) state_on(ON_READY);
  motion_t motion = wanted();
  if (!is_allowed(&motion)) motion = motion_rest();
  motor_tick(motion.direction, analog_at_supply(motion.counts));
  keep_books(&motion);
  tell();
  sum_kept = sum_now();
}

void controller_remember(void) {
  const status_t now = controller_status();
  const uint8_t before = board_remembered(PLACE_FAULT);
  if (now.fault == before) return;
  board_remember(PLACE_FAULT, (uint8_t)now.fault);
  if (now.fault == FAULT_NONE) return;
  const uint8_t next = board_remembered(PLACE_NEXT) % LOGGED_MOST, place = PLACE_LOG + LOGGED_BYTES * next;
  const uint16_t time_s = (uint16_t)(now.time_ms / 1000);
  board_remember(place, (uint8_t)now.fault);
  board_remember(place + 1, (uint8_t)now.before_fault);
  board_remember(place + 2, (uint8_t)time_s);
  board_remember(place + 3, (uint8_t)(time_s >> 8));
  board_remember(PLACE_NEXT, next + 1);
}

uint8_t controller_logged(uint8_t which, logged_t* logged) {
  const uint8_t next = board_remembered(PLACE_NEXT) % LOGGED_MOST;
  const uint8_t place = PLACE_LOG + LOGGED_BYTES * ((uint8_t)(next + LOGGED_MOST - 1 - which) % LOGGED_MOST);
  logged->fault = board_remembered(place);
  logged->state = board_remembered(place + 1);
  logged->time_s = (uint16_t)(board_remembered(place + 2) | board_remembered(place + 3) << 8);
  return which < LOGGED_MOST && logged->fault != FAULT_NONE;
}

static void put(request_t request, reply_t reply, int16_t counts, uint16_t ms) {
  ATOMICALLY {
    if (asked_count < REQUESTS_MOST) {
      const asked_t what = {request, reply, counts, ms};
      asked[asked_count++] = what;
    }
  }
}

uint8_t controller_has_room(void) {
  return asked_count < REQUESTS_MOST;  // the tick takes none away
}
void controller_request(request_t request, int16_t jog_counts, uint16_t jog_ms) {
  put(request, REPLY_NONE, jog_counts, jog_ms);
}
void controller_request_reply(reply_t reply) {
  put(REQUEST_REPLY, reply, 0, 0);
}

void controller_hold(void) {
  hold_asked = 1;
}
void controller_abort(void) {
  abort_asked = 1;
}
void controller_heard(void) {
  heard = 1;
}

status_t controller_status(void) {
  status_t now;
  ATOMICALLY {
    now = told;
  }
  return now;
}

reply_t controller_take_reply(void) {
  reply_t taken = REPLY_NONE;
  ATOMICALLY {
    if (asked_count > 0) taken = asked[0].reply;
    if (taken != REPLY_NONE) {
      --asked_count;
      memmove(asked, asked + 1, asked_count * sizeof *asked);
    }
  }
  return taken;
}

uint8_t controller_take_news(void) {
  uint8_t taken;
  ATOMICALLY {
    taken = machine.news;
    machine.news = 0;
  }
  return taken;
}
