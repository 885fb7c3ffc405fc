// Serial line, 115200 baud, 8N1: interrupt-driven in both directions. Not for use inside interrupts.
#ifndef LAKE_SERIAL_H
#define LAKE_SERIAL_H

#include <stdint.h>

#define SERIAL_LINE_MAX 32

void serial_init(void);

// A line without its end, once it is whole; 0 if there is none. Valid until the next call. A line that is too long is
// given as "?".
const char* serial_line(void);

void serial_text(const char* flash_text);  // a string in flash, from PSTR()
void serial_char(char c);                  // waits while the buffer is full
void serial_uint(uint32_t value);

// value / 10^digits as a decimal number with that many digits: (-1234, 3) is -1.234.
void serial_decimal(int32_t value, uint8_t digits);

#endif
