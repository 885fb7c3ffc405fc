#include "state.h"

#include "end_stops.h"
#include "portable.h"

machine_t machine;

#define STATES_ALL (STATES_MOVING | STATES_OF(STATE_IDLE) | STATES_OF(STATE_HOLD))

// All that changes the state.
typedef struct {
  uint16_t from;
  uint8_t event, to;
} row_t;
static const row_t rows[] PROGMEM = {
    {STATES_OF(STATE_IDLE), ON_HOME, STATE_CHECKING_HOME},
    {STATES_OF(STATE_IDLE), ON_RUN, STATE_CHECKING_RUN},
    {STATES_OF(STATE_IDLE), ON_JOG, STATE_CHECKING_JOG},
    {STATES_OF(STATE_CHECKING_HOME), ON_READY, STATE_SEEKING},
    {STATES_OF(STATE_SEEKING), ON_PRESSED, STATE_PROVING},
    {STATES_OF(STATE_PROVING), ON_DONE, STATE_BACKING_OFF},
    {STATES_OF(STATE_BACKING_OFF), ON_DONE, STATE_TOUCHING},
    {STATES_OF(STATE_TOUCHING), ON_PRESSED, STATE_RELEASING},
    {STATES_OF(STATE_RELEASING), ON_DONE, STATE_POSITIONING},
    {STATES_OF(STATE_POSITIONING), ON_DONE, STATE_IDLE},
    {STATES_OF(STATE_CHECKING_RUN), ON_READY, STATE_RUNNING},
    {STATES_OF(STATE_RUNNING), ON_DONE, STATE_IDLE},
    {STATES_OF(STATE_CHECKING_JOG), ON_READY, STATE_JOGGING},
    {STATES_OF(STATE_JOGGING), ON_DONE, STATE_IDLE},
    {STATES_PROGRAM, ON_HOLD, STATE_HOLD},
    {STATES_HOMING | STATES_JOG, ON_HOLD, STATE_IDLE},
    {STATES_PROGRAM | STATES_HOMING, ON_LET_GO, STATE_HOLD},
    {STATES_JOG, ON_LET_GO, STATE_IDLE},
    {STATES_ALL, ON_STOP, STATE_IDLE},
    {STATES_ALL, ON_FAULT, STATE_FAULT},
    {STATES_ALL | STATES_OF(STATE_FAULT), ON_RESET, STATE_IDLE},
};

state_t transition(state_t state, event_t event) {
  const uint16_t from = STATES_OF(state);  // shifted once: the chip does it bit by bit
  for (uint8_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
    if (pgm_read_byte(&rows[i].event) == event && (pgm_read_word(&rows[i].from) & from))
      return (state_t)pgm_read_byte(&rows[i].to);
  }
  return STATE_COUNT;
}

uint8_t state_on(event_t event) {
  const state_t next = transition(machine.state, event);
  if (next == STATE_COUNT) return 0;
  machine.state = next;
  machine.clock_ms = 0;
  return 1;
}

uint8_t state_is_in(uint16_t states) {
  return (states & STATES_OF(machine.state)) != 0;
}

uint8_t state_kept(kept_t what) {
  return kept_pass(&machine, offsetof(machine_t, news), what);
}

void state_finish(knowledge_t known) {
  state_on(ON_DONE);
  machine.knowledge = known;
  machine.news |= NEWS_DONE;
}

void state_fault(fault_t what) {
  if (machine.fault != FAULT_NONE) return;
  machine.before_fault = machine.state;
  state_on(ON_FAULT);
  machine.fault = what;
  machine.knowledge = STROKE_UNKNOWN;
  machine.news |= NEWS_FAULT;
}

uint8_t state_end_stop_ahead(int8_t direction) {
  const uint8_t pressed = end_stops_pressed();
  return (direction > 0 && (pressed & END_STOP_EXTEND)) || (direction < 0 && (pressed & END_STOP_RETRACT));
}
