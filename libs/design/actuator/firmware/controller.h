// What the actuator does: a state machine that runs once per ms inside the timer's interrupt, so a busy or dead main
// loop cannot keep it from an end stop. Without feedback the stroke is the plan's, integrated from the speeds of the
// tables while the bridge drives, with a bound on how far the actuator may be from it; the limits hold for the plan and
// for what the bound allows. With a potentiometer it follows the plan, and the limits hold for what that says.
// Before homing no limit holds but the end stops.
#ifndef LAKE_CONTROLLER_H
#define LAKE_CONTROLLER_H

#include <stdint.h>

typedef enum {
  STATE_IDLE,
  STATE_HOMING,
  STATE_POSITIONING,
  STATE_RUNNING,
  STATE_HOLD,
  STATE_JOGGING,
  STATE_FAULT
} state_t;

// How well the stroke is known.
typedef enum {
  STROKE_UNKNOWN,    // after a reset or a fault
  STROKE_ESTIMATED,  // good enough for the soft limits
  STROKE_AT_START    // where the program begins: a run is allowed
} knowledge_t;

typedef enum {
  REQUEST_NONE,
  REQUEST_RUN,
  REQUEST_STOP,
  REQUEST_HOME,
  REQUEST_ZERO,
  REQUEST_RESET,
  REQUEST_JOG
} request_t;

// The answer to a request. Beyond REPLY_OK the number is the N of `error:N`.
typedef enum {
  REPLY_NONE = -1,
  REPLY_OK = 0,
  REPLY_UNKNOWN = 1,      // no such command
  REPLY_BAD_NUMBER = 2,   // not `jog DUTY MS` within its ranges and the duty table's
  REPLY_TOO_LONG = 3,     // the line did not fit
  REPLY_STATE = 4,        // not in this state
  REPLY_POSITION = 5,     // the actuator is not at the program's start
  REPLY_NO_PROGRAM = 6,   // a calibration firmware has none
  REPLY_STOP_AHEAD = 7,   // an end stop is pressed in that direction
  REPLY_LIMIT_AHEAD = 8,  // a soft limit is reached in that direction
} reply_t;

// What happened unasked; bits. The faults' bit numbers are the N of `ALARM:N`, from 1.
enum {
  EVENT_FAULT_STOP = 1 << 0,          // an end stop in the direction of motion
  EVENT_FAULT_BOTH_STOPS = 1 << 1,    // both at once: wiring
  EVENT_FAULT_SOFT_LIMIT = 1 << 2,    // the plan left the soft limits
  EVENT_FAULT_HOME = 1 << 3,          // no end stop met while homing
  EVENT_FAULT_STUCK = 1 << 4,         // an end stop that is pressed away from its place: its wire
  EVENT_FAULT_SUPPLY = 1 << 5,        // the motor's supply is outside its limits: off, or its sense wire
  EVENT_FAULT_WIPER = 1 << 6,         // the potentiometer reads what it cannot
  EVENT_FAULT_NO_MOTION = 1 << 7,     // driven, it does not move: a stall, or a frozen wiper
  EVENT_FAULT_WRONG_WAY = 1 << 8,     // it moves against the drive: motor or potentiometer reversed
  EVENT_FAULT_RUNAWAY = 1 << 9,       // it moves undriven, or much faster than driven
  EVENT_FAULT_FOLLOWING = 1 << 10,    // too far from the plan
  EVENT_FAULT_OVERCURRENT = 1 << 11,  // a short or a stall
  EVENT_FAULT_NO_CURRENT = 1 << 12,   // driven, it takes none: motor, supply or sense wire
  EVENT_DONE = 1 << 13,               // the program, homing or a jog ended as planned
  EVENT_JOG_LIMIT = 1 << 14,          // a jog ended at an end stop or a soft limit
  EVENT_TIMEOUT = 1 << 15             // the host was silent for too long while something moved
};
enum { FAULT_COUNT = 13 };

typedef struct {
  uint32_t time_ms;
  int32_t stroke_um;
  uint32_t drift_um;    // how far the actuator may be from it, by the tolerances of stroke_table.h
  int32_t measured_um;  // by the potentiometer; 0 without
  int16_t current_ma;   // 0 without a sensor
  uint16_t counts;
  int8_t direction;
  state_t state;
  knowledge_t knowledge;
  uint8_t end_stops;
} status_t;

void controller_init(void);
void controller_tick(void);

// From the main loop. A request is taken by the next tick, which has its reply. `jog`: signed duty in counts and a
// duration.
void controller_request(request_t request, int16_t jog_counts, uint16_t jog_ms);
reply_t controller_take_reply(void);  // REPLY_NONE until there is one
uint16_t controller_take_events(void);
status_t controller_status(void);

// From interrupts as well; they act at the next tick. A hold keeps a running program's place and ends homing and jogs;
// it outdoes a resume of the same ms.
void controller_hold(void);
void controller_resume(void);
void controller_abort(void);  // as REQUEST_RESET, without a reply
void controller_heard(void);  // the host is there: LAKE_COMMAND_TIMEOUT_MS begins anew

#endif
