// Drives a knee exoskeleton's linear actuator through the stroke program of stroke_table.h.
//
// Build:  avr-gcc -mmcu=atmega328p -std=gnu99 -Os *.c -o lake_stroke.elf
// Upload: avr-objcopy -O ihex lake_stroke.elf lake_stroke.hex
//         avrdude -c arduino -p m328p -P /dev/ttyACM0 -b 115200 -U flash:w:lake_stroke.hex
// Wiring, commands and safety: README of libs/actuator in the lake project.
#include <avr/interrupt.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"
#include "controller.h"
#include "end_stops.h"
#include "motor.h"
#include "serial.h"

static volatile uint8_t ticks;
static uint8_t reset_cause __attribute__((section(".noinit")));

// After a watchdog reset the watchdog runs on with its shortest time: it must be off before anything else.
void quiet_watchdog(void) __attribute__((naked, used, section(".init3")));
void quiet_watchdog(void) {
  reset_cause = MCUSR;
  MCUSR = 0;
  wdt_disable();
}

ISR(TIMER2_COMPA_vect) {
  controller_tick();
  ++ticks;
}

static void timer_init(void) {
  // Timer 2: 16 MHz / 64 / 250 = 1 kHz.
  TCCR2A = _BV(WGM21);
  TCCR2B = _BV(CS22);
  OCR2A = 249;
  TIMSK2 = _BV(OCIE2A);
}

static void adc_init(void) {
  ADMUX = _BV(REFS0) | ADC_CHANNEL;
  ADCSRA = _BV(ADEN) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0);
}

static void tell(const char* flash_text) {
  serial_text(PSTR("# "));
  serial_text(flash_text);
  serial_char('\n');
}

static void tell_header(void) {
  serial_text(PSTR("time_s,planned_mm,duty,direction,state,adc,end_stops\n"));
}

static void tell_state(state_t state) {
  switch (state) {
    case STATE_IDLE:
      serial_text(PSTR("idle"));
      return;
    case STATE_HOMING:
      serial_text(PSTR("homing"));
      return;
    case STATE_POSITIONING:
      serial_text(PSTR("positioning"));
      return;
    case STATE_RUNNING:
      serial_text(PSTR("running"));
      return;
    case STATE_PAUSED:
      serial_text(PSTR("paused"));
      return;
    case STATE_JOGGING:
      serial_text(PSTR("jogging"));
      return;
    case STATE_FAULT:
      serial_text(PSTR("fault"));
      return;
  }
}

// One row under the header; duty is signed, the planned stroke is empty while unknown.
static void tell_status(void) {
  const status_t now = controller_status();
  serial_decimal(now.time_ms, 3);
  serial_char(',');
  if (now.knowledge != STROKE_UNKNOWN) serial_decimal(now.stroke_um, 3);
  serial_char(',');
  serial_decimal(now.direction * (int32_t)((now.counts * 10000UL + LAKE_PWM_PERIOD / 2) / LAKE_PWM_PERIOD), 4);
  serial_char(',');
  if (now.direction < 0) serial_char('-');
  serial_char(now.direction ? '1' : '0');
  serial_char(',');
  tell_state(now.state);
  serial_char(',');
  serial_uint(ADC);
  serial_char(',');
  serial_uint(now.end_stops);
  serial_char('\n');
}

static void tell_event(event_t event) {
  switch (event) {
    case EVENT_NONE:
      return;
    case EVENT_OK:
      tell(PSTR("ok"));
      return;
    case EVENT_REFUSED_STATE:
      tell(PSTR("refused: not in this state; stop, or reset after a fault"));
      return;
    case EVENT_REFUSED_POSITION:
      tell(PSTR("refused: not at the start; home, or zero if it is there"));
      return;
    case EVENT_REFUSED_PROGRAM:
      tell(PSTR("refused: this firmware is for calibration and has no program"));
      return;
    case EVENT_REFUSED_STOP:
      tell(PSTR("refused: end stop pressed"));
      return;
    case EVENT_REFUSED_LIMIT:
      tell(PSTR("refused: soft limit"));
      return;
    case EVENT_DONE:
      tell(PSTR("done"));
      return;
    case EVENT_JOG_LIMIT:
      tell(PSTR("jog ended at an end stop or soft limit"));
      return;
    case EVENT_FAULT_STOP:
      tell(PSTR("fault: end stop"));
      return;
    case EVENT_FAULT_BOTH_STOPS:
      tell(PSTR("fault: both end stops; check their wires"));
      return;
    case EVENT_FAULT_SOFT_LIMIT:
      tell(PSTR("fault: soft limit"));
      return;
    case EVENT_FAULT_HOME:
      tell(PSTR("fault: no end stop met while homing"));
      return;
  }
}

// "jog DUTY MS": duty in thousandths, signed.
static void command_jog(const char* text) {
  char* rest;
  const long duty = strtol(text, &rest, 10);
  char* end;
  const long duration = strtol(rest, &end, 10);
  if (rest == text || end == rest || *end != 0 || duty == 0 || duty < -1000 || duty > 1000 || duration < 1 ||
      duration > (long)JOG_MAX_MS) {
    tell(PSTR("refused: jog DUTY MS, DUTY -1000..1000 but not 0, MS 1..10000"));
    return;
  }
  controller_request(REQUEST_JOG, duty * (long)LAKE_PWM_PERIOD / 1000, duration);
}

static void obey(const char* line) {
  if (!strcmp_P(line, PSTR("start"))) {
    controller_request(REQUEST_START, 0, 0);
  } else if (!strcmp_P(line, PSTR("stop"))) {
    controller_request(REQUEST_STOP, 0, 0);
  } else if (!strcmp_P(line, PSTR("pause"))) {
    controller_request(REQUEST_PAUSE, 0, 0);
  } else if (!strcmp_P(line, PSTR("home"))) {
    controller_request(REQUEST_HOME, 0, 0);
  } else if (!strcmp_P(line, PSTR("zero"))) {
    controller_request(REQUEST_ZERO, 0, 0);
  } else if (!strcmp_P(line, PSTR("reset"))) {
    controller_request(REQUEST_RESET, 0, 0);
  } else if (!strcmp_P(line, PSTR("header"))) {
    tell_header();
  } else if (!strncmp_P(line, PSTR("jog "), 4)) {
    command_jog(line + 4);
#ifdef LAKE_SIMULATOR
  } else if (!strcmp_P(line, PSTR("hang"))) {
    for (;;) {
    }
  } else if (!strcmp_P(line, PSTR("quit"))) {
    cli();
    sleep_mode();
#endif
  } else {
    tell(PSTR("unknown; start stop pause home zero reset header jog"));
  }
}

static void tell_reset_cause(void) {
  if (reset_cause & _BV(WDRF))
    tell(PSTR("lake-stroke: the watchdog reset it"));
  else if (reset_cause & _BV(BORF))
    tell(PSTR("lake-stroke: reset by low voltage"));
  else
    tell(PSTR("lake-stroke"));
}

int main(void) {
  motor_init();
  end_stops_init();
  controller_init();
  serial_init();
  adc_init();
  timer_init();
  set_sleep_mode(SLEEP_MODE_IDLE);
  wdt_enable(WDTO_120MS);
  sei();
  tell_reset_cause();
  tell_header();
  uint8_t last_tick = ticks;
  uint32_t next_status_ms = STATUS_PERIOD_MS;
  for (;;) {
    sleep_mode();
    if (ticks == last_tick) continue;  // only a running timer and a running loop together feed the watchdog
    last_tick = ticks;
    wdt_reset();
    ADCSRA |= _BV(ADSC);  // done long before the next ms
    const char* line = serial_line();
    if (line) obey(line);
    tell_event(controller_take_event());
    if ((int32_t)(controller_status().time_ms - next_status_ms) >= 0) {
      next_status_ms += STATUS_PERIOD_MS;
      tell_status();
    }
  }
}
