#include "end_stops.h"

#include "config.h"

static uint8_t pressed;
static uint8_t changed_for_ms[2];

static uint8_t read_pins(void) {
  uint8_t bits = 0;
  if (PIND & _BV(RETRACT_STOP_BIT)) bits |= END_STOP_RETRACT;
  if (PIND & _BV(EXTEND_STOP_BIT)) bits |= END_STOP_EXTEND;
  return bits;
}

void end_stops_init(void) {
  DDRD &= ~(_BV(RETRACT_STOP_BIT) | _BV(EXTEND_STOP_BIT));
  PORTD |= _BV(RETRACT_STOP_BIT) | _BV(EXTEND_STOP_BIT);
  pressed = END_STOP_RETRACT | END_STOP_EXTEND;
}

void end_stops_tick(void) {
  const uint8_t differs = read_pins() ^ pressed;
  for (uint8_t i = 0; i < 2; ++i) {
    const uint8_t bit = 1 << i;
    if (!(differs & bit)) {
      changed_for_ms[i] = 0;
    } else if (++changed_for_ms[i] >= DEBOUNCE_MS) {
      pressed ^= bit;
      changed_for_ms[i] = 0;
    }
  }
}

uint8_t end_stops_pressed(void) {
  return pressed;
}
