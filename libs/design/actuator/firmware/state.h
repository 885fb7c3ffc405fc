// What the parts of the controller share: what the actuator does, how well its stroke is known, what happened. No
// interrupt touches it.
#ifndef LAKE_STATE_H
#define LAKE_STATE_H

#include <stddef.h>
#include <stdint.h>

#include "kept.h"

// What the actuator does. Numbers 0 to 7 stand in the EEPROMs of boards (controller_logged).
typedef enum {
  STATE_IDLE,
  STATE_SEEKING,  // homing: retracts until the end stop is pressed, …
  STATE_POSITIONING,
  STATE_RUNNING,
  STATE_HOLD,
  STATE_JOGGING,
  STATE_FAULT,
  STATE_CHECKING_HOME,  // what was asked for waits until the relay is closed and the bridge has been looked at
  STATE_PROVING,        // … slowly off it, until the motor has been seen to turn as it is told, …
  STATE_BACKING_OFF,    // … until it must have released, …
  STATE_TOUCHING,       // … to it again, …
  STATE_RELEASING,      // … and off it again
  STATE_CHECKING_RUN,
  STATE_CHECKING_JOG,
  STATE_COUNT
} state_t;

// Sets of states, a bit each.
#define STATES_OF(state) ((uint16_t)(1u << (state)))
#define STATES_HOMING                                                                      \
  (STATES_OF(STATE_CHECKING_HOME) | STATES_OF(STATE_SEEKING) | STATES_OF(STATE_PROVING) |  \
   STATES_OF(STATE_BACKING_OFF) | STATES_OF(STATE_TOUCHING) | STATES_OF(STATE_RELEASING) | \
   STATES_OF(STATE_POSITIONING))
#define STATES_CHECKING (STATES_OF(STATE_CHECKING_HOME) | STATES_OF(STATE_CHECKING_RUN) | STATES_OF(STATE_CHECKING_JOG))
#define STATES_PROGRAM (STATES_OF(STATE_CHECKING_RUN) | STATES_OF(STATE_RUNNING))
#define STATES_JOG (STATES_OF(STATE_CHECKING_JOG) | STATES_OF(STATE_JOGGING))
#define STATES_MOVING (STATES_HOMING | STATES_PROGRAM | STATES_JOG)

// What changes the state. The first three are asked for, and allowed by what is known of stroke and end stops.
typedef enum {
  ON_HOME,
  ON_RUN,
  ON_JOG,
  ON_STOP,  // or Ctrl-X
  ON_RESET,
  ON_HOLD,
  ON_LET_GO,   // the host is silent for the time-out, or the button released
  ON_READY,    // power_is_ready
  ON_PRESSED,  // the retract end stop, while homing
  ON_DONE,     // as planned, or what a jog meets
  ON_FAULT,
  ON_COUNT
} event_t;

// The state after an event; STATE_COUNT where that changes nothing. SAFETY.md has a drawing of it.
state_t transition(state_t state, event_t event);

// How well the stroke is known.
typedef enum {
  STROKE_UNKNOWN,    // after a reset or a fault
  STROKE_ESTIMATED,  // good enough for the soft limits
  STROKE_AT_START    // where the program begins: a run is allowed
} knowledge_t;

// The answer to a request. Beyond REPLY_OK the number is the N of `error:N`.
typedef enum {
  REPLY_NONE = -1,  // nothing was asked, or the reply comes later
  REPLY_OK = 0,
  REPLY_UNKNOWN = 1,      // no such command
  REPLY_BAD_NUMBER = 2,   // not `jog DUTY MS` within its ranges and the duty table's
  REPLY_TOO_LONG = 3,     // the line did not fit
  REPLY_STATE = 4,        // not in this state
  REPLY_POSITION = 5,     // the actuator is not at the program's start
  REPLY_NO_PROGRAM = 6,   // a calibration firmware has none
  REPLY_STOP_AHEAD = 7,   // an end stop is pressed in that direction
  REPLY_LIMIT_AHEAD = 8,  // a soft limit is reached in that direction
  REPLY_CHECK_SUM = 9,    // the line has no check sum, or a wrong one
  REPLY_BUTTON = 10,      // nobody holds the button
  REPLY_TRIES = 11        // homing has failed HOME_TRIES times
} reply_t;

// What went wrong, the N of `ALARM:N`; the first one stays until it is acknowledged.
typedef enum {
  FAULT_NONE = 0,
  FAULT_STOP = 1,          // an end stop in the direction of motion
  FAULT_BOTH_STOPS = 2,    // both at once: wiring
  FAULT_SOFT_LIMIT = 3,    // the plan left the soft limits
  FAULT_HOME = 4,          // no end stop met while homing
  FAULT_STUCK = 5,         // an end stop that is pressed away from its place: its wire
  FAULT_SUPPLY = 6,        // the motor's supply is outside its limits: off, or its sense wire
  FAULT_WIPER = 7,         // the potentiometer reads what it cannot
  FAULT_NO_MOTION = 8,     // driven, it does not move: a stall, or a frozen wiper
  FAULT_WRONG_WAY = 9,     // it moves against the drive: motor or potentiometer reversed
  FAULT_RUNAWAY = 10,      // it moves undriven, or much faster than driven
  FAULT_FOLLOWING = 11,    // too far from the plan, or too slow for it
  FAULT_OVERCURRENT = 12,  // a short or a stall
  FAULT_NO_CURRENT = 13,   // driven, it takes none: motor, supply or sense wire
  FAULT_LATE = 14,         // a tick or a round of conversions did not end within its ms
  FAULT_BRIDGE = 15,       // the bridge does not follow its commands: ENA's jumper, a wire, a transistor
  FAULT_RELAY = 16,        // the safety relay does not open
  FAULT_MEMORY = 17        // what was kept has changed by itself
} fault_t;

// What happened unasked; bits, in the order in which they are told.
enum {
  NEWS_FAULT = 1 << 0,      // machine.fault has come
  NEWS_WAITED = 1 << 1,     // the program has ended later than planned
  NEWS_DONE = 1 << 2,       // the program, homing or a jog ended as planned
  NEWS_JOG_LIMIT = 1 << 3,  // a jog ended at an end stop or a soft limit
  NEWS_TIMEOUT = 1 << 4,    // the host was silent for too long while something moved
  NEWS_BUTTON = 1 << 5      // the button was released while something moved
};

// What is wanted of the motor in this ms.
typedef struct {
  int8_t direction;
  uint16_t counts;
  int32_t velocity_um_s;
  uint32_t spread_um_s;  // by which it may be slower, beside the tolerances
} motion_t;

// Field by field: the compiler keeps a constant motion in RAM, where a bit may flip.
static inline motion_t motion_of(int8_t direction, uint16_t counts, int32_t velocity_um_s) {
  motion_t motion;
  motion.direction = direction;
  motion.counts = counts;
  motion.velocity_um_s = velocity_um_s;
  motion.spread_um_s = 0;
  return motion;
}

static inline motion_t motion_rest(void) {
  return motion_of(0, 0, 0);
}

typedef struct {
  state_t state;
  knowledge_t knowledge;
  uint32_t clock_ms;  // of the program, of homing, or of a jog
  uint32_t end_ms;
  fault_t fault;
  state_t before_fault;  // in which it came
  uint8_t news;          // the last: whoever tells takes them
} machine_t;
extern machine_t machine;

uint8_t state_kept(kept_t what);

// Nonzero if the event has changed the state; its clock begins anew.
uint8_t state_on(event_t event);
uint8_t state_is_in(uint16_t states);
void state_finish(knowledge_t known);  // as planned
void state_fault(fault_t what);        // unless there is one

// Is the end stop pressed towards which that direction leads?
uint8_t state_end_stop_ahead(int8_t direction);

#endif
