// What the parts of the controller share: what the actuator does, how well its stroke is known, what happened. The tick
// alone changes it; the main loop reads it in ATOMICALLY blocks, which are barriers.
#ifndef LAKE_STATE_H
#define LAKE_STATE_H

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

// What is wanted of the motor in this ms.
typedef struct {
  int8_t direction;
  uint16_t counts;
  int32_t velocity_um_s;
  uint32_t spread_um_s;  // by which it may be slower, beside the tolerances
} motion_t;

static const motion_t kRest = {0, 0, 0, 0};

typedef struct {
  state_t state;
  knowledge_t knowledge;
  uint32_t clock_ms;  // of the program, of homing, or of a jog
  uint32_t end_ms;
  uint16_t events;
} machine_t;
extern machine_t machine;

void state_begin(state_t next, uint32_t duration_ms);
void state_finish(knowledge_t known);  // as planned
void state_fault(uint16_t what);

// Is the end stop pressed towards which that direction leads?
uint8_t state_end_stop_ahead(int8_t direction);

#endif
