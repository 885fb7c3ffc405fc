// What the actuator does: the table of state.h, asked and worked off once per ms in the main loop; what cannot wait for
// that stops the motor in the interrupt (guard.h). Without feedback the stroke is the plan's, integrated from the
// speeds of the tables while the bridge drives, with a bound on how far the actuator may be from it; the limits hold
// for the plan and for what the bound allows. With a potentiometer it follows the plan, and the limits hold for what
// that says. Before homing no limit holds but the end stops.
#ifndef LAKE_CONTROLLER_H
#define LAKE_CONTROLLER_H

#include "state.h"

typedef enum { REQUEST_RUN, REQUEST_STOP, REQUEST_HOME, REQUEST_ZERO, REQUEST_RESET, REQUEST_JOG } request_t;

typedef struct {
  uint32_t time_ms;
  int32_t stroke_um;
  uint32_t drift_um;    // how far the actuator may be from it, by the tolerances of stroke_table.h
  int32_t measured_um;  // by the potentiometer; 0 without
  int16_t current_ma;   // 0 without a sensor
  uint16_t counts;
  int8_t direction;
  state_t state;
  fault_t fault;
  state_t before_fault;  // in which it came
  knowledge_t knowledge;
  uint8_t end_stops;
} status_t;

void controller_init(void);  // with the fault that nobody has acknowledged before a reset, if there is one
void controller_turn(void);  // once per ms

// Keeps the fault for after a reset, and a new one in the log of faults: a byte of it at most, as board_remember.
void controller_remember(void);

// The log of faults, the newest first: what went wrong, in what state, how long after the reset. Nonzero if there is a
// `which`-th. Only while board_can_remember.
typedef struct {
  uint8_t fault, state;
  uint16_t time_s;
} logged_t;
#define LOGGED_MOST 16
uint8_t controller_logged(uint8_t which, logged_t* logged);

// Obeyed at once or refused. `jog`: signed duty in counts and a duration.
reply_t controller_ask(request_t request, int16_t jog_counts, uint16_t jog_ms);
uint8_t controller_take_news(void);
status_t controller_status(void);
uint32_t controller_time_ms(void);
void controller_heard(void);  // the host is there: LAKE_COMMAND_TIMEOUT_MS begins anew

// From interrupts as well; they act at the next turn, until which nothing else is obeyed. A hold stops a running
// program, which REQUEST_STOP then ends, and ends homing and jogs.
void controller_hold(void);
void controller_abort(void);  // ends what moves and forgets the stroke; a fault stays

#endif
