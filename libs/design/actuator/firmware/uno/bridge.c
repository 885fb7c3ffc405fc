#include "bridge.h"

#include <avr/interrupt.h>
#include <util/atomic.h>
#include <util/delay_basic.h>

#include "config.h"
#include "pins.h"

// A 10 kOhm resistor from ENA to ground keeps the bridge off while the UNO starts or is unplugged, and pulls the pin
// down where it is read. Timer 1 has the PWM: D9 is its output A, D10 its B.
#define SETTLE_LOOPS 54  // 162 clocks, 10 us: the pin's capacitance, the bridge's rise

#define CONNECT_TO(pin) ((pin) == 9 ? _BV(COM1A1) : _BV(COM1B1))

static volatile int8_t direction_now;

#if LAKE_BRIDGE_SENSE

// A period is looked at in two interrupts of timer 1, each of which asks for itself anew: at the PWM's rise and at its
// fall. Soon after the fall the motor's current still flows, through the diodes, and holds the driven output at ground;
// once it has ended the output has the voltage that the motor generates.
#define RISE_LOOPS 43    // 129 clocks, 8 us: delay and rise of an L298N (data sheet: 3 us), and the divider's
#define FALL_LOOPS 21    // 63 clocks, 4 us: its delay and fall (2 us)
#define LOW_CLOCKS 160   // 10 us: a shorter low part, from 96 % of duty on, is not looked at
#define LATE_CLOCKS 320  // 20 us after the fall: by another interrupt, too late to tell

static volatile uint8_t contradicts, contradicts_high;  // of the last looks that could tell

static uint8_t driven_is_high(void) {
  return direction_now > 0 ? PIN_READ(LAKE_PIN_OUT1) : PIN_READ(LAKE_PIN_OUT2);
}
static uint8_t other_is_high(void) {
  return direction_now > 0 ? PIN_READ(LAKE_PIN_OUT2) : PIN_READ(LAKE_PIN_OUT1);
}

ISR(TIMER1_OVF_vect) {
  _delay_loop_1(RISE_LOOPS);
  const uint8_t is_wrong = !driven_is_high() || other_is_high();
  if (TCNT1 < OCR1A) contradicts_high = is_wrong;
  TIFR1 = _BV(OCF1A);
  TIMSK1 = _BV(OCIE1A);
}

ISR(TIMER1_COMPA_vect) {
  TIMSK1 = 0;
  _delay_loop_1(FALL_LOOPS);
  const uint8_t is_high = driven_is_high() != 0;
  const uint16_t fall = OCR1A;
  if (contradicts_high || fall > LAKE_PWM_PERIOD - LOW_CLOCKS)
    contradicts = contradicts_high;
  else if ((uint16_t)(TCNT1 - fall) < LATE_CLOCKS)
    contradicts = is_high;
}

static void stop_looking(void) {
  TIMSK1 = 0;
  contradicts = contradicts_high = 0;
}

uint8_t bridge_outputs_contradict(void) {
  const uint8_t last = contradicts;
  TIFR1 = _BV(TOV1);
  TIMSK1 = _BV(TOIE1);
  return last;
}

#else

static void stop_looking(void) {}

uint8_t bridge_outputs_contradict(void) {
  return 0;
}

#endif

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
  stop_looking();
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

void bridge_drive(uint16_t counts) {
  const uint8_t is_full = counts >= LAKE_PWM_PERIOD;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {  // the halves of timer 1's registers share one place with those of the looks
    OCR1A = OCR1B = counts - 1;        // high for one clock more of each period
  }
  TCCR1A = _BV(WGM11) | (is_full ? 0 : CONNECT_TO(LAKE_PIN_ENA));
  PIN_WRITE(LAKE_PIN_ENA, is_full);
}

int8_t bridge_driven(void) {
  if (!(TCCR1A & CONNECT_TO(LAKE_PIN_ENA)) && !PIN_IS_SET(LAKE_PIN_ENA)) return 0;
  return (int8_t)((PIN_IS_SET(LAKE_PIN_IN1) != 0) - (PIN_IS_SET(LAKE_PIN_IN2) != 0));
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
