// What the actuator does: a state machine that runs once per ms inside the timer's interrupt, so a busy or dead main
// loop cannot keep it from an end stop. Open loop: the stroke is the plan's, integrated from the speeds of the tables
// while the bridge drives.
#ifndef LAKE_CONTROLLER_H
#define LAKE_CONTROLLER_H

#include <stdint.h>

typedef enum {
  STATE_IDLE,
  STATE_HOMING,
  STATE_POSITIONING,
  STATE_RUNNING,
  STATE_PAUSED,
  STATE_JOGGING,
  STATE_FAULT
} state_t;

// How well the stroke is known.
typedef enum {
  STROKE_UNKNOWN,    // after a reset or a fault
  STROKE_ESTIMATED,  // good enough for the soft limits
  STROKE_AT_START    // where the program begins: `start` is allowed
} knowledge_t;

typedef enum {
  REQUEST_NONE,
  REQUEST_START,
  REQUEST_STOP,
  REQUEST_PAUSE,
  REQUEST_HOME,
  REQUEST_ZERO,
  REQUEST_RESET,
  REQUEST_JOG
} request_t;

// What happened last, for the main loop to tell.
typedef enum {
  EVENT_NONE,
  EVENT_OK,
  EVENT_REFUSED_STATE,     // not in this state
  EVENT_REFUSED_POSITION,  // the actuator is not at the program's start
  EVENT_REFUSED_PROGRAM,   // a calibration firmware has no program
  EVENT_REFUSED_STOP,      // an end stop is pressed in that direction
  EVENT_REFUSED_LIMIT,     // a soft limit is reached in that direction
  EVENT_DONE,              // the program, homing or a jog ended as planned
  EVENT_JOG_LIMIT,         // a jog ended at an end stop or a soft limit
  EVENT_FAULT_STOP,        // an end stop in the direction of motion
  EVENT_FAULT_BOTH_STOPS,  // both at once: wiring
  EVENT_FAULT_SOFT_LIMIT,  // the plan left the soft limits
  EVENT_FAULT_HOME         // no end stop met while homing
} event_t;

typedef struct {
  uint32_t time_ms;
  int32_t stroke_um;
  uint16_t counts;
  int8_t direction;
  state_t state;
  knowledge_t knowledge;
  uint8_t end_stops;
} status_t;

void controller_init(void);
void controller_tick(void);

// From the main loop. A request is taken by the next tick and answered by an event. `jog`: signed duty in counts and a
// duration.
void controller_request(request_t request, int16_t jog_counts, uint16_t jog_ms);
status_t controller_status(void);
event_t controller_take_event(void);

#endif
