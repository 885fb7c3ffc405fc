#include "state.h"

#include "end_stops.h"

machine_t machine;

void state_begin(state_t next, uint32_t duration_ms) {
  machine.state = next;
  machine.clock_ms = 0;
  machine.end_ms = duration_ms;
}

void state_finish(knowledge_t known) {
  machine.state = STATE_IDLE;
  machine.knowledge = known;
  machine.events |= EVENT_DONE;
}

void state_fault(uint16_t what) {
  machine.state = STATE_FAULT;
  machine.knowledge = STROKE_UNKNOWN;
  machine.events |= what;
}

uint8_t state_end_stop_ahead(int8_t direction) {
  const uint8_t pressed = end_stops_pressed();
  return (direction > 0 && (pressed & END_STOP_EXTEND)) || (direction < 0 && (pressed & END_STOP_RETRACT));
}
