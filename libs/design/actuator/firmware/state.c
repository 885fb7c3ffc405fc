#include "state.h"

#include "end_stops.h"
#include "portable.h"

machine_t machine;

void state_begin(state_t next, uint32_t duration_ms) {
  machine.state = next;
  machine.clock_ms = 0;
  machine.end_ms = duration_ms;
}

uint16_t state_sum(void) {
  return sum_of(&machine, offsetof(machine_t, events));
}

void state_finish(knowledge_t known) {
  machine.state = STATE_IDLE;
  machine.knowledge = known;
  machine.events |= EVENT_DONE;
}

void state_fault(fault_t what) {
  if (machine.fault != FAULT_NONE) return;
  machine.before_fault = machine.state;
  machine.state = STATE_FAULT;
  machine.fault = what;
  machine.knowledge = STROKE_UNKNOWN;
  machine.events |= EVENT_FAULT;
}

uint8_t state_end_stop_ahead(int8_t direction) {
  const uint8_t pressed = end_stops_pressed();
  return (direction > 0 && (pressed & END_STOP_EXTEND)) || (direction < 0 && (pressed & END_STOP_RETRACT));
}
