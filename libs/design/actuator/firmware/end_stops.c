#include "end_stops.h"

#include "config.h"

static volatile uint8_t seen;
static uint8_t pressed;
static uint8_t released_for_ms[2];

void end_stops_init(void) {
  seen = pressed = END_STOP_RETRACT | END_STOP_EXTEND;
  released_for_ms[0] = released_for_ms[1] = 0;
}

uint8_t end_stops_interrupt(void) {
  const uint8_t now = board_end_stops();
  uint8_t bits = seen;
  for (uint8_t i = 0; i < 2; ++i) {
    const uint8_t bit = (uint8_t)(1 << i);
    if (now & bit) {
      bits |= bit;
      released_for_ms[i] = 0;
    } else if ((bits & bit) && ++released_for_ms[i] >= END_STOP_RELEASE_MS) {
      bits &= (uint8_t)~bit;
    }
  }
  seen = bits;
  return bits;
}

void end_stops_turn(void) {
  pressed = seen;
}

uint8_t end_stops_pressed(void) {
  return pressed;
}
