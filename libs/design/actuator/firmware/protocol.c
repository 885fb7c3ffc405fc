#include "protocol.h"

#include <stdlib.h>

#include "config.h"
#include "controller.h"
#include "portable.h"
#include "serial.h"

#define CTRL_X 0x18

static volatile uint8_t status_asked, greeting_asked;
static uint32_t next_row_ms = STATUS_PERIOD_MS;

uint8_t protocol_realtime(char c) {
  switch (c) {
    case '?':
      status_asked = 1;
      break;
    case '!':
      controller_hold();
      break;
    case '~':
      controller_resume();
      break;
    case CTRL_X:
      controller_abort();
      greeting_asked = 1;
      break;
    default:
      return 0;
  }
  controller_heard();
  return 1;
}

static void tell_uint(uint32_t value) {
  char digits[10];
  uint8_t count = 0;
  do {
    digits[count++] = '0' + value % 10;
    value /= 10;
  } while (value > 0);
  while (count > 0) serial_char(digits[--count]);
}

// value / 10^digits with that many digits after the point: (-1234, 3) is -1.234.
static void tell_decimal(int32_t value, uint8_t digits) {
  uint32_t scale = 1;
  for (uint8_t i = 0; i < digits; ++i) scale *= 10;
  if (value < 0) serial_char('-');
  const uint32_t magnitude = value < 0 ? -(uint32_t)value : (uint32_t)value;
  tell_uint(magnitude / scale);
  serial_char('.');
  for (uint32_t rest = magnitude % scale; digits > 0; --digits) {
    scale /= 10;
    serial_char('0' + rest / scale);
    rest %= scale;
  }
}

static void tell_message(const char* flash_text) {
  serial_text(PSTR("[MSG:"));
  serial_text(flash_text);
  serial_text(PSTR("]\n"));
}

static void tell_header(void) {
  serial_text(PSTR("time_s,planned_mm,drift_mm,duty,direction,state,adc,end_stops"));
#if LAKE_FEEDBACK
  serial_text(PSTR(",measured_mm,error_mm"));
#endif
#if LAKE_CURRENT_SENSE
  serial_text(PSTR(",current_a"));
#endif
  serial_char('\n');
}

void protocol_greet(reset_cause_t cause) {
  if (cause == RESET_BY_WATCHDOG)
    tell_message(PSTR("lake-stroke, reset by the watchdog"));
  else if (cause == RESET_BY_LOW_VOLTAGE)
    tell_message(PSTR("lake-stroke, reset by low voltage"));
  else
    tell_message(PSTR("lake-stroke"));
#if LAKE_SEGMENT_COUNT > 0 && LAKE_DRIFT_ACCEPTED
  tell_message(PSTR("drift accepted, no person"));
#endif
#if LAKE_SEGMENT_COUNT > 0
  tell_message(PSTR("design " LAKE_DESIGN ", duty table " LAKE_DUTY_TABLE));
#endif
#if LAKE_SEGMENT_COUNT > 0 && !LAKE_FEEDBACK
  tell_message(PSTR("open loop: the stroke is planned, not measured"));
#endif
  tell_header();
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
    case STATE_HOLD:
      serial_text(PSTR("hold"));
      return;
    case STATE_JOGGING:
      serial_text(PSTR("jogging"));
      return;
    case STATE_FAULT:
      serial_text(PSTR("fault"));
      return;
  }
}

// Planned stroke and drift bound, both empty while the stroke is unknown.
static void tell_stroke(const status_t* now, const char* between) {
  if (now->knowledge != STROKE_UNKNOWN) tell_decimal(now->stroke_um, 3);
  serial_text(between);
  if (now->knowledge != STROKE_UNKNOWN) tell_decimal(now->drift_um, 3);
}

static void tell_duty(const status_t* now) {
  tell_decimal(now->direction * (int32_t)((now->counts * 10000UL + LAKE_PWM_PERIOD / 2) / LAKE_PWM_PERIOD), 4);
}

static void tell_row(const status_t* now) {
  tell_decimal(now->time_ms, 3);
  serial_char(',');
  tell_stroke(now, PSTR(","));
  serial_char(',');
  tell_duty(now);
  serial_char(',');
  if (now->direction < 0) serial_char('-');
  serial_char(now->direction ? '1' : '0');
  serial_char(',');
  tell_state(now->state);
  serial_char(',');
  tell_uint((board_analog(ANALOG_POTENTIOMETER) + 2) / 4);
  serial_char(',');
  tell_uint(now->end_stops);
#if LAKE_FEEDBACK
  serial_char(',');
  tell_decimal(now->measured_um, 3);
  serial_char(',');
  if (now->knowledge != STROKE_UNKNOWN) tell_decimal(now->stroke_um - now->measured_um, 3);
#endif
#if LAKE_CURRENT_SENSE
  serial_char(',');
  tell_decimal(now->current_ma, 3);
#endif
  serial_char('\n');
}

// <state|stroke:MM|drift:MM|duty:D|stops:N>
static void tell_status(const status_t* now) {
  serial_char('<');
  tell_state(now->state);
  serial_text(PSTR("|stroke:"));
  tell_stroke(now, PSTR("|drift:"));
  serial_text(PSTR("|duty:"));
  tell_duty(now);
  serial_text(PSTR("|stops:"));
  tell_uint(now->end_stops);
  serial_text(PSTR(">\n"));
}

static void tell_reply(reply_t reply) {
  if (reply == REPLY_NONE) return;
  if (reply == REPLY_OK) {
    serial_text(PSTR("ok\n"));
    return;
  }
  serial_text(PSTR("error:"));
  tell_uint(reply);
  serial_char('\n');
}

static void tell_events(uint8_t events, fault_t fault) {
  if (events & EVENT_FAULT) {
    serial_text(PSTR("ALARM:"));
    tell_uint(fault);
    serial_char('\n');
  }
  if (events & EVENT_DONE) tell_message(PSTR("done"));
  if (events & EVENT_JOG_LIMIT) tell_message(PSTR("jog ended at a limit"));
  if (events & EVENT_TIMEOUT) tell_message(PSTR("host silent, stopped"));
}

// "jog DUTY MS": duty in thousandths, signed.
static void obey_jog(const char* text) {
  char* rest;
  const long duty = strtol(text, &rest, 10);
  char* end;
  const long duration = strtol(rest, &end, 10);
  if (rest == text || end == rest || *end != 0 || duty == 0 || duty < -1000 || duty > 1000 || duration < 1 ||
      duration > JOG_MAX_MS) {
    tell_reply(REPLY_BAD_NUMBER);
    return;
  }
  controller_request(REQUEST_JOG, (int16_t)(duty * LAKE_PWM_PERIOD / 1000), (uint16_t)duration);
}

static void obey(const char* line) {
  if (!strcmp_P(line, PSTR("run"))) {
    controller_request(REQUEST_RUN, 0, 0);
  } else if (!strcmp_P(line, PSTR("stop"))) {
    controller_request(REQUEST_STOP, 0, 0);
  } else if (!strcmp_P(line, PSTR("home"))) {
#if LAKE_SEGMENT_COUNT > 0
    tell_message(PSTR("unworn only: homing takes the knee to " LAKE_HOME_KNEE " degrees"));
#endif
    controller_request(REQUEST_HOME, 0, 0);
  } else if (!strcmp_P(line, PSTR("zero"))) {
    controller_request(REQUEST_ZERO, 0, 0);
  } else if (!strcmp_P(line, PSTR("reset"))) {
    controller_request(REQUEST_RESET, 0, 0);
  } else if (!strcmp_P(line, PSTR("header"))) {
    tell_header();
    tell_reply(REPLY_OK);
  } else if (!strncmp_P(line, PSTR("jog "), 4)) {
    obey_jog(line + 4);
#ifdef LAKE_SIMULATOR
  } else if (!strcmp_P(line, PSTR("hang"))) {
    board_hang();
  } else if (!strcmp_P(line, PSTR("quit"))) {
    board_quit();
#endif
  } else {
    tell_reply(strchr(line, '\n') ? REPLY_TOO_LONG : REPLY_UNKNOWN);
  }
}

void protocol_turn(void) {
  const char* line = serial_line();
  if (line) obey(line);
  tell_reply(controller_take_reply());
  const uint8_t events = controller_take_events();
  const status_t now = controller_status();
  tell_events(events, now.fault);
  if (greeting_asked) {
    greeting_asked = 0;
    protocol_greet(RESET_BY_POWER_OR_BUTTON);
  }
  if (status_asked) {
    status_asked = 0;
    tell_status(&now);
  }
  if ((int32_t)(now.time_ms - next_row_ms) < 0) return;
  next_row_ms = now.time_ms + STATUS_PERIOD_MS;
  tell_row(&now);
}
