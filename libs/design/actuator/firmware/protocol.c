#include "protocol.h"

#include <stdlib.h>

#include "config.h"
#include "controller.h"
#include "line.h"
#include "portable.h"
#include "program.h"

static volatile uint8_t status_asked, greeting_asked, must_forget;
static uint32_t next_row_ms = STATUS_PERIOD_MS;
#define NOT_TELLING 255
static uint8_t fault_to_tell = NOT_TELLING;  // of the log

realtime_t protocol_realtime(char c) {
  switch (c) {
    case '?':
      status_asked = 1;
      return REALTIME_DONE;
    case '!':
      controller_hold();
      must_forget = 1;
      return REALTIME_FORGET;
    case SERIAL_FORGET:  // Ctrl-X
      controller_abort();
      greeting_asked = 1;
      must_forget = 1;
      return REALTIME_FORGET;
    default:
      return REALTIME_NONE;
  }
}

static void tell_uint(uint32_t value) {
  char digits[10];
  uint8_t count = 0;
  do {
    digits[count++] = '0' + value % 10;
    value /= 10;
  } while (value > 0);
  while (count > 0) line_char(digits[--count]);
}

// value / 10^digits with that many digits after the point: (-1234, 3) is -1.234.
static void tell_decimal(int32_t value, uint8_t digits) {
  uint32_t scale = 1;
  for (uint8_t i = 0; i < digits; ++i) scale *= 10;
  if (value < 0) line_char('-');
  const uint32_t magnitude = value < 0 ? -(uint32_t)value : (uint32_t)value;
  tell_uint(magnitude / scale);
  line_char('.');
  for (uint32_t rest = magnitude % scale; digits > 0; --digits) {
    scale /= 10;
    line_char('0' + rest / scale);
    rest %= scale;
  }
}

static void tell_time(uint32_t ms) {
  tell_uint(ms / 1000);
  line_char('.');
  for (uint16_t scale = 100, rest = ms % 1000; scale > 0; scale /= 10) {
    line_char('0' + rest / scale);
    rest %= scale;
  }
}

static void tell_message(const char* flash_text) {
  line_text(PSTR("[MSG:"));
  line_text(flash_text);
  line_text(PSTR("]\n"));
}

static void tell_header(void) {
  line_text(PSTR("time_s,planned_mm,drift_mm,duty,direction,state,adc,end_stops"));
#if LAKE_FEEDBACK
  line_text(PSTR(",measured_mm,error_mm"));
#endif
#if LAKE_CURRENT_SENSE
  line_text(PSTR(",current_a"));
#endif
  line_char('\n');
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
  tell_message(PSTR("program " LAKE_PROGRAM));
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
      line_text(PSTR("idle"));
      return;
    case STATE_SEEKING:
    case STATE_PROVING:
    case STATE_BACKING_OFF:
    case STATE_TOUCHING:
    case STATE_RELEASING:
      line_text(PSTR("homing"));
      return;
    case STATE_POSITIONING:
      line_text(PSTR("positioning"));
      return;
    case STATE_RUNNING:
      line_text(PSTR("running"));
      return;
    case STATE_HOLD:
      line_text(PSTR("hold"));
      return;
    case STATE_JOGGING:
      line_text(PSTR("jogging"));
      return;
    case STATE_FAULT:
      line_text(PSTR("fault"));
      return;
    case STATE_CHECKING_HOME:
    case STATE_CHECKING_RUN:
    case STATE_CHECKING_JOG:
      line_text(PSTR("checking"));
      return;
    case STATE_COUNT:
      return;
  }
}

// Planned stroke and drift bound, both empty while the stroke is unknown.
static void tell_stroke(const status_t* now, const char* between) {
  if (now->knowledge != STROKE_UNKNOWN) tell_decimal(now->stroke_um, 3);
  line_text(between);
  if (now->knowledge != STROKE_UNKNOWN) tell_decimal(now->drift_um, 3);
}

static void tell_duty(const status_t* now) {
  tell_decimal(now->direction * (int32_t)((now->counts * 10000UL + LAKE_PWM_PERIOD / 2) / LAKE_PWM_PERIOD), 4);
}

static void tell_row(const status_t* now) {
  tell_time(now->time_ms);
  line_char(',');
  tell_stroke(now, PSTR(","));
  line_char(',');
  tell_duty(now);
  line_char(',');
  if (now->direction < 0) line_char('-');
  line_char(now->direction ? '1' : '0');
  line_char(',');
  tell_state(now->state);
  line_char(',');
  tell_uint((board_analog(ANALOG_POTENTIOMETER) + 2) / 4);
  line_char(',');
  tell_uint(now->end_stops);
#if LAKE_FEEDBACK
  line_char(',');
  tell_decimal(now->measured_um, 3);
  line_char(',');
  if (now->knowledge != STROKE_UNKNOWN) tell_decimal(now->stroke_um - now->measured_um, 3);
#endif
#if LAKE_CURRENT_SENSE
  line_char(',');
  tell_decimal(now->current_ma, 3);
#endif
  line_char('\n');
}

// <state|stroke:MM|drift:MM|duty:D|stops:N>
static void tell_status(const status_t* now) {
  line_char('<');
  tell_state(now->state);
  line_text(PSTR("|stroke:"));
  tell_stroke(now, PSTR("|drift:"));
  line_text(PSTR("|duty:"));
  tell_duty(now);
  line_text(PSTR("|stops:"));
  tell_uint(now->end_stops);
  line_text(PSTR(">\n"));
}

static void tell_reply(reply_t reply) {
  if (reply == REPLY_OK) {
    line_text(PSTR("ok\n"));
    return;
  }
  line_text(PSTR("error:"));
  tell_uint(reply);
  line_char('\n');
}

#if LAKE_FEEDBACK
static void tell_waited(void) {
  line_text(PSTR("[MSG:waited "));
  tell_decimal((int32_t)program_waited_ms(), 3);
  line_text(PSTR(" s]\n"));
}
#endif

static void tell_news(uint8_t news, fault_t fault) {
  if (news & NEWS_FAULT) {
    line_text(PSTR("ALARM:"));
    tell_uint(fault);
    line_char('\n');
  }
#if LAKE_FEEDBACK
  if (news & NEWS_WAITED) tell_waited();
#endif
  if (news & NEWS_DONE) tell_message(PSTR("done"));
  if (news & NEWS_JOG_LIMIT) tell_message(PSTR("jog ended at a limit"));
  if (news & NEWS_TIMEOUT) tell_message(PSTR("host silent, stopped"));
}

// The next tick replies. A line that was being read when a hold or an abort came is not obeyed.
static void ask(request_t request, int16_t jog_counts, uint16_t jog_ms) {
  ATOMICALLY {
    if (must_forget)
      controller_request_reply(REPLY_STATE);
    else
      controller_request(request, jog_counts, jog_ms);
  }
}

// "jog DUTY MS": duty in thousandths, signed.
static void obey_jog(const char* text) {
  char* rest;
  const long duty = strtol(text, &rest, 10);
  char* end;
  const long duration = strtol(rest, &end, 10);
  if (rest == text || end == rest || *end != 0 || duty == 0 || duty < -1000 || duty > 1000 || duration < 1 ||
      duration > JOG_MAX_MS) {
    controller_request_reply(REPLY_BAD_NUMBER);
    return;
  }
  ask(REQUEST_JOG, (int16_t)(duty * LAKE_PWM_PERIOD / 1000), (uint16_t)duration);
}

// [FAULT:n,state,time_s], the newest first; one a turn, as the whole log takes 50 ms to say.
static void tell_log(void) {
  logged_t logged;
  if (!controller_logged(fault_to_tell++, &logged)) {
    fault_to_tell = NOT_TELLING;
    controller_request_reply(REPLY_OK);
    return;
  }
  line_text(PSTR("[FAULT:"));
  tell_uint(logged.fault);
  line_char(',');
  tell_state((state_t)logged.state);
  line_char(',');
  tell_uint(logged.time_s);
  line_text(PSTR("]\n"));
}

// Those that move nothing and forget nothing; nonzero if it was one.
static uint8_t obey_harmless(const char* line) {
  if (!strcmp_P(line, PSTR("stop"))) {
    ask(REQUEST_STOP, 0, 0);
  } else if (!strcmp_P(line, PSTR("header"))) {
    tell_header();
    controller_request_reply(REPLY_OK);
  } else if (!strcmp_P(line, PSTR("who"))) {
    greeting_asked = 1;
  } else if (!strcmp_P(line, PSTR("faults"))) {
    fault_to_tell = 0;
  } else {
    return 0;
  }
  return 1;
}

static void obey(const char* line) {
  if (!strcmp_P(line, PSTR("alive"))) {
    status_asked = 1;
  } else if (!strcmp_P(line, PSTR("run"))) {
    ask(REQUEST_RUN, 0, 0);
  } else if (!strcmp_P(line, PSTR("home"))) {
#if LAKE_SEGMENT_COUNT > 0
    tell_message(PSTR("unworn only: homing takes the knee to " LAKE_HOME_KNEE " degrees"));
#endif
    ask(REQUEST_HOME, 0, 0);
  } else if (!strcmp_P(line, PSTR("zero"))) {
    ask(REQUEST_ZERO, 0, 0);
  } else if (!strcmp_P(line, PSTR("reset"))) {
    ask(REQUEST_RESET, 0, 0);
  } else if (!strncmp_P(line, PSTR("jog "), 4)) {
    obey_jog(line + 4);
#ifdef LAKE_SIMULATOR
  } else if (!strcmp_P(line, PSTR("hang"))) {
    board_hang();
  } else if (!strcmp_P(line, PSTR("quit"))) {
    board_quit();
#endif
  } else {
    controller_request_reply(REPLY_UNKNOWN);
  }
}

static void take_line(void) {
  const char* line;
  switch (line_read(&line)) {
    case LINE_FRAMED:
      controller_heard();
      if (!obey_harmless(line)) obey(line);
      return;
    case LINE_PLAIN:
      if (!obey_harmless(line)) controller_request_reply(REPLY_CHECK_SUM);
      return;
    case LINE_TOO_LONG:
      controller_request_reply(REPLY_TOO_LONG);
      return;
    case LINE_DAMAGED:
      controller_request_reply(REPLY_CHECK_SUM);
      return;
    case LINE_NONE:
      return;
  }
}

// Says the answer to one line, or one fault of the log, at most: the watchdog does not wait while it is said.
void protocol_turn(void) {
  for (reply_t reply; (reply = controller_take_reply()) != REPLY_NONE;) tell_reply(reply);
  must_forget = 0;
  if (fault_to_tell != NOT_TELLING)
    tell_log();
  else if (controller_has_room())
    take_line();
  const uint8_t news = controller_take_news();
  const status_t now = controller_status();
  tell_news(news, now.fault);
  if (greeting_asked) {
    greeting_asked = 0;
    protocol_greet(RESET_BY_POWER_OR_BUTTON);
    if (now.fault != FAULT_NONE) tell_news(NEWS_FAULT, now.fault);
  }
  if (status_asked) {
    status_asked = 0;
    tell_status(&now);
  }
  if ((int32_t)(now.time_ms - next_row_ms) < 0) return;
  next_row_ms = now.time_ms + STATUS_PERIOD_MS;
  tell_row(&now);
}
