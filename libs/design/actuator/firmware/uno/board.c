#include "board.h"

#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <util/atomic.h>
#include <util/delay_basic.h>

#include "config.h"
#include "pins.h"

#define END_STOP_READINGS 4

// The time of one ms, with everything wired; FirmwareTimingTest holds the rig's against it.
//
//   interrupt  what cannot wait: end stops, current, motor off; nothing interrupts it             <= 50 us
//   converter  a round of 12 conversions: each 13 clocks of 4 us, at most one to the clock's next edge, and the
//              interrupt that begins the next                                      12 x 60 us = 720 us
//   main loop  the controller, and what is said meanwhile, a line or a field of a row at a time: it may make the
//              controller late by less than a ms, which is done after it
//
// The converter fixes its channel when a conversion begins and knows no second one beside it. So its own interrupt,
// which comes when a conversion has ended, begins the next; the timer's begins a round only after the last one's end.
#define LATE_MS 4  // that the main loop may be behind
#define CONVERSIONS 4  // of each channel in a round

static const uint8_t kWired[] PROGMEM = {
    ANALOG_POTENTIOMETER,
#if LAKE_CURRENT_SENSE
    ANALOG_CURRENT,
#endif
#if LAKE_SUPPLY_SENSE
    ANALOG_SUPPLY,
#endif
};

static volatile uint8_t ticks, done, is_late;
static volatile uint16_t readings[ANALOG_COUNT];
static uint16_t sum;
static uint8_t wired, conversion;
static volatile uint8_t is_round_over = 1;
static uint8_t reset_flags __attribute__((section(".noinit")));

// After a watchdog reset the watchdog runs on with its shortest time: it must be off before anything else.
void quiet_watchdog(void) __attribute__((naked, used, section(".init3")));
void quiet_watchdog(void) {
  reset_flags = MCUSR;
  MCUSR = 0;
  wdt_disable();
}

static uint8_t channel(void) {
  return pgm_read_byte(&kWired[wired]);
}

// In line, so that the converter's interrupt, twelve in each ms, keeps few registers.
static inline __attribute__((always_inline)) void begin_conversion(void) {
  ADMUX = _BV(REFS0) | channel();
  ADCSRA |= _BV(ADSC);
}

ISR(ADC_vect) {
  sum += ADC;
  if (++conversion >= CONVERSIONS) {
    if (wired < sizeof kWired) readings[channel()] = sum;
    sum = 0;
    conversion = 0;
    if (++wired >= sizeof kWired) {
      wired = 0;
      is_round_over = 1;
      return;
    }
  }
  begin_conversion();
}

static void begin_round(void) {
  if (!is_round_over) {
    is_late = 1;
    return;
  }
  is_round_over = 0;
  begin_conversion();
}

ISR(TIMER2_COMPA_vect) {
  begin_round();
  if ((uint8_t)(++ticks - done) > LATE_MS) is_late = 1;
  board_interrupt();
}

void board_init(void) {
  // Normally closed switches to ground with the internal pull-ups: a pressed switch, a broken wire and a missing switch
  // all read high.
  PIN_WRITE(LAKE_PIN_RETRACT, 1);
  PIN_WRITE(LAKE_PIN_EXTEND, 1);
  if (LAKE_BUTTON) PIN_WRITE(LAKE_PIN_BUTTON, 1);  // to ground while it is held: a broken wire reads as released
  if (LAKE_RELAY) PIN_OUTPUT(LAKE_PIN_RELAY, 1);
  ADMUX = _BV(REFS0);
  ADCSRA = _BV(ADEN) | _BV(ADIE) | _BV(ADPS2) | _BV(ADPS1);  // 250 kHz
}

void board_start(void) {
  // Timer 2: 16 MHz / 64 / 250 = 1 kHz.
  TCCR2A = _BV(WGM21);
  TCCR2B = _BV(CS22);
  OCR2A = 249;
  TIMSK2 = _BV(OCIE2A);
  set_sleep_mode(SLEEP_MODE_IDLE);
  wdt_enable(WDTO_120MS);
  sei();
}

uint8_t board_is_due(void) {
  return ticks != done;
}

void board_sleep(void) {
  cli();
  if (ticks == done) {
    sleep_enable();
    sei();  // acts after the next instruction: no interrupt comes before it sleeps
    sleep_cpu();
    sleep_disable();
  }
  sei();
}

void board_done(void) {
  ++done;
  wdt_reset();
}

static uint8_t open_stops(void) {
  uint8_t bits = 0;
  if (PIN_READ(LAKE_PIN_RETRACT)) bits |= END_STOP_RETRACT;
  if (PIN_READ(LAKE_PIN_EXTEND)) bits |= END_STOP_EXTEND;
  if (LAKE_BUTTON && PIN_READ(LAKE_PIN_BUTTON)) bits |= BUTTON_RELEASED;
  return bits;
}

uint8_t board_end_stops(void) {
  uint8_t open = open_stops();
  for (uint8_t i = 1; i < END_STOP_READINGS; ++i) {
    _delay_loop_1(26);  // 78 clocks, 5 us
    open &= open_stops();
  }
  return open;
}

void board_close_relay(uint8_t is_closed) {
  if (LAKE_RELAY) PIN_WRITE(LAKE_PIN_RELAY, is_closed);
}

uint16_t board_analog(uint8_t which) {
  uint16_t reading = 0;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    reading = readings[which];
  }
  return reading;
}

uint8_t board_is_late(void) {
  return is_late;
}

// Erased a place reads 255.
static uint8_t* place_of(uint8_t place) {
  return (uint8_t*)(uint16_t)place;
}

uint8_t board_can_remember(void) {
  return eeprom_is_ready() != 0;
}

uint8_t board_remembered(uint8_t place) {
  return (uint8_t)~eeprom_read_byte(place_of(place));
}

void board_remember(uint8_t place, uint8_t number) {
  eeprom_update_byte(place_of(place), (uint8_t)~number);
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
