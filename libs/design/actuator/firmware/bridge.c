#include "bridge.h"

#include <avr/io.h>

#include "config.h"

// A 10 kOhm resistor from ENA to ground keeps the bridge off while the UNO starts or is unplugged.
#define ENA_BIT PB1  // D9, output A of timer 1
#define IN1_BIT PD7  // D7
#define IN2_BIT PB0  // D8

static void disconnect_pwm(void) {
  TCCR1A = _BV(WGM11);
}

void bridge_init(void) {
  PORTB &= ~(_BV(ENA_BIT) | _BV(IN2_BIT));
  PORTD &= ~_BV(IN1_BIT);
  DDRB |= _BV(ENA_BIT) | _BV(IN2_BIT);
  DDRD |= _BV(IN1_BIT);
  // Timer 1: fast PWM up to ICR1 (mode 14), no prescaler.
  disconnect_pwm();
  ICR1 = LAKE_PWM_PERIOD - 1;
  TCCR1B = _BV(WGM13) | _BV(WGM12) | _BV(CS10);
}

void bridge_off(void) {
  disconnect_pwm();
  PORTB &= ~_BV(ENA_BIT);
}

static void enable_full(void) {
  disconnect_pwm();
  PORTB |= _BV(ENA_BIT);
}

void bridge_brake(void) {
  bridge_off();
  bridge_direct(0);
  enable_full();
}

void bridge_direct(int8_t direction) {
  if (direction > 0)
    PORTD |= _BV(IN1_BIT);
  else
    PORTD &= ~_BV(IN1_BIT);
  if (direction < 0)
    PORTB |= _BV(IN2_BIT);
  else
    PORTB &= ~_BV(IN2_BIT);
}

void bridge_drive(uint16_t counts) {
  if (counts >= LAKE_PWM_PERIOD) {
    enable_full();
    return;
  }
  OCR1A = counts - 1;  // high for OCR1A + 1 clocks of each period
  TCCR1A = _BV(COM1A1) | _BV(WGM11);
}
