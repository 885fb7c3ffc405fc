#include "motor.h"

#include "config.h"

static int8_t driving;
static uint16_t driving_counts;
static uint16_t brake_left_ms;

static void disconnect_pwm(void) {
  TCCR1A = _BV(WGM11);
}

static void enable_off(void) {
  disconnect_pwm();
  PORTB &= ~_BV(ENA_BIT);
}

static void enable_full(void) {
  disconnect_pwm();
  PORTB |= _BV(ENA_BIT);
}

static void enable_pwm(uint16_t counts) {
  OCR1A = counts - 1;  // high for OCR1A + 1 clocks of each period
  TCCR1A = _BV(COM1A1) | _BV(WGM11);
}

static void set_inputs(uint8_t in1, uint8_t in2) {
  if (in1)
    PORTD |= _BV(IN1_BIT);
  else
    PORTD &= ~_BV(IN1_BIT);
  if (in2)
    PORTB |= _BV(IN2_BIT);
  else
    PORTB &= ~_BV(IN2_BIT);
}

// Both outputs low with the bridge enabled: the motor is shorted.
static void start_brake(void) {
  enable_off();
  set_inputs(0, 0);
  enable_full();
  driving = 0;
  driving_counts = 0;
  brake_left_ms = LAKE_DEAD_TIME_MS;
}

static void drive(int8_t direction, uint16_t counts) {
  if (driving == direction && driving_counts == counts) return;
  if (driving == 0) set_inputs(direction > 0, direction < 0);
  if (counts >= LAKE_PWM_PERIOD)
    enable_full();
  else
    enable_pwm(counts);
  driving = direction;
  driving_counts = counts;
}

void motor_init(void) {
  PORTB &= ~(_BV(ENA_BIT) | _BV(IN2_BIT));
  PORTD &= ~_BV(IN1_BIT);
  DDRB |= _BV(ENA_BIT) | _BV(IN2_BIT);
  DDRD |= _BV(IN1_BIT);
  // Timer 1: fast PWM up to ICR1 (mode 14), no prescaler.
  disconnect_pwm();
  ICR1 = LAKE_PWM_PERIOD - 1;
  TCCR1B = _BV(WGM13) | _BV(WGM12) | _BV(CS10);
  driving = 0;
  driving_counts = 0;
  brake_left_ms = 0;
}

void motor_tick(int8_t direction, uint16_t counts) {
  if (counts == 0) direction = 0;
  if (driving != 0 && direction != driving) {
    start_brake();
    return;
  }
  if (brake_left_ms > 0) {
    if (--brake_left_ms > 0) return;
    enable_off();
  }
  if (direction != 0) drive(direction, counts);
}

int8_t motor_direction(void) {
  return driving;
}
uint16_t motor_counts(void) {
  return driving_counts;
}
