#include "line.h"

#include "portable.h"
#include "serial.h"

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

line_kind_t line_read(const char** text) {
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

void line_char(char c) {
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

void line_text(const char* flash_text) {
  for (char c; (c = (char)pgm_read_byte(flash_text)); ++flash_text) line_char(c);
}
