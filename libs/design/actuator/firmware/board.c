#include "board.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <util/atomic.h>
#include <util/delay_basic.h>

#include "config.h"

// Normally closed switches to ground with the internal pull-ups. A pressed switch, a broken wire and a missing switch
// all read high.
#define RETRACT_STOP_BIT PD2  // D2, at the shortest stroke
#define EXTEND_STOP_BIT PD3   // D3, at the longest stroke
#define END_STOP_READINGS 4

#if LAKE_FEEDBACK || LAKE_CURRENT_SENSE || LAKE_SUPPLY_SENSE
#define CONVERSIONS 4  // of each channel per ms, at 52 us
#define CHANNELS ANALOG_COUNT
#else
#define CONVERSIONS 1  // the potentiometer is only told
#define CHANNELS 1
#endif

static void (*on_tick)(void);
static volatile uint8_t ticks;
static uint8_t last_tick;
static volatile uint16_t readings[ANALOG_COUNT];
static uint16_t sum;
static uint8_t channel, conversion;
static uint8_t reset_flags __attribute__((section(".noinit")));

// After a watchdog reset the watchdog runs on with its shortest time: it must be off before anything else.
void quiet_watchdog(void) __attribute__((naked, used, section(".init3")));
void quiet_watchdog(void) {
  reset_flags = MCUSR;
  MCUSR = 0;
  wdt_disable();
}

static void start_conversion(void) {
  ADMUX = _BV(REFS0) | channel;
  ADCSRA |= _BV(ADSC);
}

// The conversions of one ms follow upon each other: all channels are done when the next begins.
ISR(ADC_vect) {
  sum += ADC;
  if (++conversion == CONVERSIONS) {
    readings[channel] = sum * (4 / CONVERSIONS);
    sum = 0;
    conversion = 0;
    if (++channel == CHANNELS) return;
  }
  start_conversion();
}

ISR(TIMER2_COMPA_vect) {
  sum = 0;
  channel = conversion = 0;
  start_conversion();
  on_tick();
  ++ticks;
}

void board_init(void) {
  DDRD &= ~(_BV(RETRACT_STOP_BIT) | _BV(EXTEND_STOP_BIT));
  PORTD |= _BV(RETRACT_STOP_BIT) | _BV(EXTEND_STOP_BIT);
  ADMUX = _BV(REFS0);
  ADCSRA = _BV(ADEN) | _BV(ADIE) | _BV(ADPS2) | _BV(ADPS1);  // 250 kHz
}

void board_start(void (*tick)(void)) {
  on_tick = tick;
  // Timer 2: 16 MHz / 64 / 250 = 1 kHz.
  TCCR2A = _BV(WGM21);
  TCCR2B = _BV(CS22);
  OCR2A = 249;
  TIMSK2 = _BV(OCIE2A);
  set_sleep_mode(SLEEP_MODE_IDLE);
  wdt_enable(WDTO_120MS);
  sei();
}

uint8_t board_wait(void) {
  sleep_mode();
  if (ticks == last_tick) return 0;
  last_tick = ticks;
  wdt_reset();
  return 1;
}

uint8_t board_end_stops(void) {
  uint8_t open = PIND;
  for (uint8_t i = 1; i < END_STOP_READINGS; ++i) {
    _delay_loop_1(32);  // 96 clocks, 6 us
    open &= PIND;
  }
  uint8_t bits = 0;
  if (open & _BV(RETRACT_STOP_BIT)) bits |= END_STOP_RETRACT;
  if (open & _BV(EXTEND_STOP_BIT)) bits |= END_STOP_EXTEND;
  return bits;
}

uint16_t board_analog(uint8_t which) {
  uint16_t reading = 0;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    reading = readings[which];
  }
  return reading;
}

reset_cause_t board_reset_cause(void) {
  if (reset_flags & _BV(WDRF)) return RESET_BY_WATCHDOG;
  if (reset_flags & _BV(BORF)) return RESET_BY_LOW_VOLTAGE;
  return RESET_BY_POWER_OR_BUTTON;
}

#ifdef LAKE_SIMULATOR
void board_hang(void) {
  for (;;) {
  }
}

void board_quit(void) {
  cli();
  sleep_mode();
}
#endif
