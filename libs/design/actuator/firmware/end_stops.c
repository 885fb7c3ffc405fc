#include "end_stops.h"

#include "config.h"
#include "portable.h"

static volatile uint8_t seen;
static uint8_t open;
static uint8_t closed_for_ms[SWITCHES];

void end_stops_init(void) {
  seen = open = END_STOP_RETRACT | END_STOP_EXTEND | (LAKE_BUTTON ? BUTTON_RELEASED : 0);
  memset(closed_for_ms, 0, sizeof closed_for_ms);
}

uint8_t end_stops_interrupt(void) {
  const uint8_t now = board_end_stops();
  uint8_t bits = seen;
  for (uint8_t i = 0; i < SWITCHES; ++i) {
    const uint8_t bit = (uint8_t)(1 << i);
    if (now & bit) {
      bits |= bit;
      closed_for_ms[i] = 0;
    } else if ((bits & bit) && ++closed_for_ms[i] >= END_STOP_RELEASE_MS) {
      bits &= (uint8_t)~bit;
    }
  }
  seen = bits;
  return bits;
}

void end_stops_turn(void) {
  open = seen;
}

uint8_t end_stops_pressed(void) {
  return open & (END_STOP_RETRACT | END_STOP_EXTEND);
}

uint8_t end_stops_button_is_released(void) {
  return (open & BUTTON_RELEASED) != 0;
}
