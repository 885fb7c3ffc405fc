#include "bridge.h"

#include <util/delay_basic.h>

#include "config.h"
#include "pins.h"

// A 10 kOhm resistor from ENA to ground keeps the bridge off while the UNO starts or is unplugged, and pulls the pin
// down where it is read. Timer 1 has the PWM: D9 is its output A, D10 its B.
#define SETTLE_LOOPS 54  // 162 clocks, 10 us: the pin's capacitance, the bridge's rise

#define CONNECT_TO(pin) ((pin) == 9 ? _BV(COM1A1) : _BV(COM1B1))

static int8_t direction_now;

static void disconnect_pwm(void) {
  TCCR1A = _BV(WGM11);
}

static void set_inputs(uint8_t in1, uint8_t in2) {
  PIN_WRITE(LAKE_PIN_IN1, in1);
  PIN_WRITE(LAKE_PIN_IN2, in2);
}

void bridge_init(void) {
  PIN_WRITE(LAKE_PIN_ENA, 0);
  set_inputs(0, 0);
  PIN_OUTPUT(LAKE_PIN_ENA, 1);
  PIN_OUTPUT(LAKE_PIN_IN1, 1);
  PIN_OUTPUT(LAKE_PIN_IN2, 1);
  // Timer 1: fast PWM up to ICR1 (mode 14), no prescaler.
  disconnect_pwm();
  ICR1 = LAKE_PWM_PERIOD - 1;
  TCCR1B = _BV(WGM13) | _BV(WGM12) | _BV(CS10);
}

void bridge_off(void) {
  PIN_WRITE(LAKE_PIN_ENA, 0);
  disconnect_pwm();
  set_inputs(0, 0);
}

void bridge_brake(void) {
  disconnect_pwm();
  PIN_WRITE(LAKE_PIN_ENA, 1);
  _delay_loop_1(SETTLE_LOOPS);
}

void bridge_direct(int8_t direction) {
  direction_now = direction;
  set_inputs(direction > 0, direction < 0);
}

// The PWM is on ENA (L298N), or on the input that drives (BTS7960, whose outputs follow their inputs while ENA is
// high).
void bridge_drive(uint16_t counts) {
  const uint8_t is_full = counts >= LAKE_PWM_PERIOD;
  OCR1A = OCR1B = counts - 1;  // high for one clock more of each period
#if LAKE_BRIDGE_BTS7960
  TCCR1A = _BV(WGM11) | (is_full ? 0 : CONNECT_TO(direction_now > 0 ? LAKE_PIN_IN1 : LAKE_PIN_IN2));
  PIN_WRITE(LAKE_PIN_ENA, 1);
#else
  TCCR1A = _BV(WGM11) | (is_full ? 0 : CONNECT_TO(LAKE_PIN_ENA));
  PIN_WRITE(LAKE_PIN_ENA, is_full);
#endif
}

uint8_t bridge_enable_is_free(void) {
  PIN_OUTPUT(LAKE_PIN_ENA, 0);
  _delay_loop_1(SETTLE_LOOPS);
  const uint8_t is_high = PIN_READ(LAKE_PIN_ENA);
  if (!is_high) PIN_OUTPUT(LAKE_PIN_ENA, 1);  // against what holds it high it stays an input
  return !is_high;
}

uint8_t bridge_outputs_are_low(void) {
#if LAKE_BRIDGE_SENSE
  return !PIN_READ(LAKE_PIN_OUT1) && !PIN_READ(LAKE_PIN_OUT2);
#else
  return 0;
#endif
}
