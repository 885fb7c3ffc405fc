#include "protocol.h"

#include <stdlib.h>

#include "config.h"
#include "controller.h"
#include "plant.h"
#include "portable.h"
#include "serial.h"

// Lines with a check sum, in both directions: `text*HHHH`, where HHHH is the CRC-16/MCRF4XX of the text (polynomial
// 0x1021 from the lowest bit on, from 0xFFFF; avr-libc's _crc_ccitt_update) in hexadecimal digits.
#define LINE_MAX 40

typedef enum {
  LINE_NONE,     // no whole line has come
  LINE_FRAMED,   // with its check sum, which is right
  LINE_PLAIN,    // without one
  LINE_DAMAGED,  // a wrong check sum, or characters that no line has
  LINE_TOO_LONG
} line_kind_t;

#define SUM_DIGITS 4
#define SUM_START 0xFFFFu

static char received[LINE_MAX];
static uint8_t length, is_damaged, is_too_long;
static uint16_t said_sum = SUM_START;

// The eight bits at once, as avr-libc does it.
static uint16_t sum_with(uint16_t sum, char c) {
  uint8_t low = (uint8_t)((uint8_t)c ^ sum);
  low ^= (uint8_t)(low << 4);
  return (uint16_t)(((uint16_t)low << 8 | sum >> 8) ^ (uint8_t)(low >> 4) ^ (uint16_t)low << 3);
}

static char digit_of(uint16_t sum, uint8_t place) {
  const uint8_t value = sum >> (4 * place) & 0xF;
  return (char)(value < 10 ? '0' + value : 'A' + value - 10);
}

static void begin_line(void) {
  length = 0;
  is_damaged = is_too_long = 0;
}

// The text ends where the check sum begins.
static line_kind_t judge(void) {
  if (is_damaged) return LINE_DAMAGED;
  if (is_too_long || length >= LINE_MAX) return LINE_TOO_LONG;
  received[length] = 0;
  char* star = strchr(received, '*');
  if (!star) return LINE_PLAIN;
  uint16_t sum = SUM_START;
  for (const char* c = received; c != star; ++c) sum = sum_with(sum, *c);
  if (star + 1 + SUM_DIGITS != received + length) return LINE_DAMAGED;
  for (uint8_t place = 0; place < SUM_DIGITS; ++place)
    if (star[SUM_DIGITS - place] != digit_of(sum, place)) return LINE_DAMAGED;
  *star = 0;
  return LINE_FRAMED;
}

static void take(char c) {
  if (c < ' ' || c > '~')
    is_damaged = 1;
  else if (length < LINE_MAX - 1)
    received[length++] = c;
  else
    is_too_long = 1;
}

// The next whole line that was received. Its text without the check sum is valid until the next call.
static line_kind_t line_read(const char** text) {
  static uint8_t is_whole;
  if (is_whole) begin_line();
  is_whole = 0;
  for (int16_t c; (c = serial_read()) >= 0;) {
    if (c == SERIAL_FORGET) {
      begin_line();
    } else if (c != '\n' && c != '\r') {
      take((char)c);
    } else if (length > 0 || is_damaged) {
      is_whole = 1;
      *text = received;
      return judge();
    }
  }
  return LINE_NONE;
}

// What is said; a '\n' ends the line with its check sum.
static void line_char(char c) {
  if (c != '\n') {
    said_sum = sum_with(said_sum, c);
    serial_write(c);
    return;
  }
  serial_write('*');
  for (uint8_t place = SUM_DIGITS; place > 0; --place) serial_write(digit_of(said_sum, (uint8_t)(place - 1)));
  serial_write('\n');
  said_sum = SUM_START;
}

// A string in flash, from PSTR().
static void line_text(const char* flash_text) {
  for (char c; (c = (char)pgm_read_byte(flash_text)); ++flash_text) line_char(c);
}

static volatile uint8_t status_asked, greeting_asked;  // by an interrupt
static reset_cause_t cause;
static reply_t reply = REPLY_NONE;
static uint8_t news;
static uint32_t next_row_ms = STATUS_PERIOD_MS;
static status_t row;   // that is being said …
static uint8_t field;  // … from this field on; 0: none is
#define NOTHING 255
static uint8_t greeting_at = NOTHING;    // its line
static uint8_t fault_to_tell = NOTHING;  // of the log

realtime_t serial_realtime(char c) {
  switch (c) {
    case '?':
      status_asked = 1;
      return REALTIME_DONE;
    case '!':
      controller_hold();
      return REALTIME_FORGET;
    case SERIAL_FORGET:  // Ctrl-X
      controller_abort();
      greeting_asked = 1;
      return REALTIME_FORGET;
    default:
      return REALTIME_NONE;
  }
}

// Digit by digit without a division, of which one takes the chip 40 us.
static const uint32_t powers[] PROGMEM = {1000000000, 100000000, 10000000, 1000000, 100000, 10000, 1000, 100, 10, 1};

// value / 10^decimals, with so many digits after the point: (1234, 3) is 1.234.
static void tell_unsigned(uint32_t value, uint8_t decimals) {
  uint8_t has_begun = 0;
  for (uint8_t place = sizeof powers / sizeof *powers; place-- > 0;) {
    const uint32_t power = pgm_read_dword(&powers[sizeof powers / sizeof *powers - 1 - place]);
    char digit = '0';
    for (; value >= power; value -= power) ++digit;
    has_begun = has_begun || digit > '0' || place <= decimals;
    if (has_begun) line_char(digit);
    if (place == decimals && decimals > 0) line_char('.');
  }
}

static void tell_decimal(int32_t value, uint8_t decimals) {
  if (value < 0) line_char('-');
  tell_unsigned(value < 0 ? -(uint32_t)value : (uint32_t)value, decimals);
}

static void tell_message(const char* flash_text) {
  line_text(PSTR("[MSG:"));
  line_text(flash_text);
  line_text(PSTR("]\n"));
}

static void tell_header(void) {
  line_text(PSTR("time_s,planned_mm,drift_mm,duty,direction,state,adc,end_stops"));
  if (LAKE_FEEDBACK) line_text(PSTR(",measured_mm,error_mm"));
  if (LAKE_CURRENT_SENSE) line_text(PSTR(",current_a"));
  line_char('\n');
}

void protocol_greet(reset_cause_t why) {
  cause = why;
  greeting_at = 0;
}

// A line of it, or none where this firmware has nothing to say there.
static void tell_greeting(void) {
  switch (greeting_at++) {
    case 0:
      tell_message(cause == RESET_BY_WATCHDOG      ? PSTR("lake-stroke, reset by the watchdog")
                   : cause == RESET_BY_LOW_VOLTAGE ? PSTR("lake-stroke, reset by low voltage")
                                                   : PSTR("lake-stroke"));
      return;
    case 1:
      if (LAKE_DRIFT_ACCEPTED) tell_message(PSTR("drift accepted, no person"));
      return;
    case 2:
      if (LAKE_HAS_PROGRAM) tell_message(PSTR("program " LAKE_PROGRAM));
      return;
    case 3:
      if (LAKE_HAS_PROGRAM) tell_message(PSTR("design " LAKE_DESIGN ", duty table " LAKE_DUTY_TABLE));
      return;
    case 4:
      if (LAKE_HAS_PROGRAM && !LAKE_FEEDBACK)
        tell_message(PSTR("open loop: the stroke is planned, not measured"));
      return;
    case 5:
      tell_header();
      return;
    default:
      if (controller_status().fault != FAULT_NONE) news |= NEWS_FAULT;
      greeting_at = NOTHING;
  }
}

// As rows, `?` and the log of faults call the first states; those of homing and of checking beyond have the same names.
static const char kStates[][12] PROGMEM = {"idle", "homing",  "positioning", "running",
                                           "hold", "jogging", "fault",       "checking"};

static void tell_state(uint8_t state) {
  if (state >= STATE_COUNT) return;
  if (state > STATE_CHECKING_HOME) state = state < STATE_CHECKING_RUN ? STATE_SEEKING : STATE_CHECKING_HOME;
  line_text(kStates[state]);
}

// Nothing while the stroke is unknown.
static void tell_if_known(const status_t* now, int32_t um) {
  if (now->knowledge != STROKE_UNKNOWN) tell_decimal(um, 3);
}

static void tell_duty(const status_t* now) {
  tell_decimal(now->direction * (int32_t)((now->counts * 10000UL + LAKE_PWM_PERIOD / 2) / LAKE_PWM_PERIOD), 4);
}

// A field of the row: one a turn, as all of them take longer than a ms.
static void tell_field(void) {
  enum { CURRENT = 10 };
  if (field > 0) line_char(',');
  switch (field++) {
    case 0:
      row = controller_status();
      next_row_ms = row.time_ms + STATUS_PERIOD_MS;
      tell_unsigned(row.time_ms, 3);
      return;
    case 1:
      tell_if_known(&row, row.stroke_um);
      return;
    case 2:
      tell_if_known(&row, (int32_t)row.drift_um);
      return;
    case 3:
      tell_duty(&row);
      return;
    case 4:
      tell_decimal(row.direction, 0);
      return;
    case 5:
      tell_state((uint8_t)row.state);
      return;
    case 6:
      tell_unsigned((board_analog(ANALOG_POTENTIOMETER) + 2u) / 4, 0);
      return;
    case 7:
      tell_unsigned(row.end_stops, 0);
      if (LAKE_FEEDBACK) return;
      field = CURRENT;
      break;
    case 8:
      tell_decimal(row.measured_um, 3);
      return;
    case 9:
      tell_if_known(&row, row.stroke_um - row.measured_um);
      break;
    default:
      tell_decimal(row.current_ma, 3);
  }
  if (LAKE_CURRENT_SENSE && field == CURRENT) return;
  line_char('\n');
  field = 0;
}

// <state|stroke:MM|drift:MM|duty:D|stops:N>
static void tell_status(void) {
  const status_t status = controller_status(), *now = &status;
  line_char('<');
  tell_state((uint8_t)now->state);
  line_text(PSTR("|stroke:"));
  tell_if_known(now, now->stroke_um);
  line_text(PSTR("|drift:"));
  tell_if_known(now, (int32_t)now->drift_um);
  line_text(PSTR("|duty:"));
  tell_duty(now);
  line_text(PSTR("|stops:"));
  tell_unsigned(now->end_stops, 0);
  line_text(PSTR(">\n"));
}

static void tell_reply(void) {
  if (reply == REPLY_OK) {
    line_text(PSTR("ok\n"));
  } else {
    line_text(PSTR("error:"));
    tell_unsigned((uint8_t)reply, 0);
    line_char('\n');
  }
  reply = REPLY_NONE;
}

// What is new beyond NEWS_WAITED, in the order of its bits.
static const char kNews[][26] PROGMEM = {"done", "jog ended at a limit", "host silent, stopped",
                                         "button released, stopped"};

// The first of what is new.
static void tell_news(void) {
  const uint8_t first = news & (uint8_t)-news;
  news &= (uint8_t)~first;
  if (first == NEWS_FAULT) {
    line_text(PSTR("ALARM:"));
    tell_unsigned(controller_status().fault, 0);
    line_char('\n');
  } else if (first == NEWS_WAITED) {
    line_text(PSTR("[MSG:waited "));
    tell_unsigned(plant_waited_ms(), 3);
    line_text(PSTR(" s]\n"));
  } else {
    uint8_t which = 0;
    while (which + 1u < sizeof kNews / sizeof kNews[0] && NEWS_DONE << which != first) ++which;
    tell_message(kNews[which]);
  }
}

// "jog DUTY MS": duty in thousandths, signed.
static reply_t obey_jog(const char* text) {
  char* rest;
  const long duty = strtol(text, &rest, 10);
  char* end;
  const long duration = strtol(rest, &end, 10);
  if (rest == text || end == rest || *end != 0 || duty == 0 || duty < -1000 || duty > 1000 || duration < 1 ||
      duration > JOG_MAX_MS)
    return REPLY_BAD_NUMBER;
  return controller_ask(REQUEST_JOG, (int16_t)(duty * LAKE_PWM_PERIOD / 1000), (uint16_t)duration);
}

// [FAULT:n,state,time_s], the newest first.
static void tell_log(void) {
  logged_t logged;
  if (!controller_logged(fault_to_tell++, &logged)) {
    fault_to_tell = NOTHING;
    reply = REPLY_OK;
    return;
  }
  line_text(PSTR("[FAULT:"));
  tell_unsigned(logged.fault, 0);
  line_char(',');
  tell_state(logged.state);
  line_char(',');
  tell_unsigned(logged.time_s, 0);
  line_text(PSTR("]\n"));
}

static uint8_t is_harmless(const char* line) {
  return !strcmp_P(line, PSTR("stop")) || !strcmp_P(line, PSTR("header")) || !strcmp_P(line, PSTR("who")) ||
         !strcmp_P(line, PSTR("faults"));
}

static reply_t obey(const char* line) {
  if (!strcmp_P(line, PSTR("stop"))) return controller_ask(REQUEST_STOP, 0, 0);
  if (!strcmp_P(line, PSTR("run"))) return controller_ask(REQUEST_RUN, 0, 0);
  if (!strcmp_P(line, PSTR("zero"))) return controller_ask(REQUEST_ZERO, 0, 0);
  if (!strcmp_P(line, PSTR("reset"))) return controller_ask(REQUEST_RESET, 0, 0);
  if (!strncmp_P(line, PSTR("jog "), 4)) return obey_jog(line + 4);
  if (!strcmp_P(line, PSTR("home"))) {
    if (LAKE_HAS_PROGRAM)
      tell_message(PSTR("unworn only: homing takes the knee to " LAKE_HOME_KNEE " degrees"));
    return controller_ask(REQUEST_HOME, 0, 0);
  }
  if (!strcmp_P(line, PSTR("header"))) {
    tell_header();
    return REPLY_OK;
  }
  // These are answered by what they ask for.
  if (!strcmp_P(line, PSTR("alive")))
    status_asked = 1;
  else if (!strcmp_P(line, PSTR("who")))
    greeting_asked = 1;
  else if (!strcmp_P(line, PSTR("faults")))
    fault_to_tell = 0;
#ifdef LAKE_SIMULATOR
  else if (!strcmp_P(line, PSTR("hang")))
    board_hang();
  else if (!strcmp_P(line, PSTR("quit")))
    board_quit();
#endif
  else
    return REPLY_UNKNOWN;
  return REPLY_NONE;
}

static reply_t take_line(void) {
  const char* line;
  switch (line_read(&line)) {
    case LINE_FRAMED:
      controller_heard();
      return obey(line);
    case LINE_PLAIN:
      return is_harmless(line) ? obey(line) : REPLY_CHECK_SUM;
    case LINE_TOO_LONG:
      return REPLY_TOO_LONG;
    case LINE_DAMAGED:
      return REPLY_CHECK_SUM;
    case LINE_NONE:
      break;
  }
  return REPLY_NONE;
}

void protocol_turn(void) {
  if (field > 0) {
    tell_field();
    return;
  }
  if (!serial_has_room()) return;
  news |= controller_take_news();
  if (reply != REPLY_NONE) {
    tell_reply();
  } else if (greeting_at != NOTHING) {
    tell_greeting();
  } else if (greeting_asked) {
    greeting_asked = 0;
    protocol_greet(RESET_BY_POWER_OR_BUTTON);
  } else if (news) {
    tell_news();
  } else if (fault_to_tell != NOTHING) {
    if (board_can_remember()) tell_log();
  } else if (status_asked) {
    status_asked = 0;
    tell_status();
  } else if ((int32_t)(controller_time_ms() - next_row_ms) >= 0) {
    tell_field();
  } else {
    reply = take_line();
  }
}
