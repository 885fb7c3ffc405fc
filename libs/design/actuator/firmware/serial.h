// Serial line, 115200 baud, 8N1: interrupt-driven in both directions. Not for use inside interrupts.
#ifndef LAKE_SERIAL_H
#define LAKE_SERIAL_H

#include <stdint.h>

#define SERIAL_LINE_MAX 32

// `realtime` is called for every character inside the receiver's interrupt, before it becomes part of a line; nonzero:
// it was a command of its own and does not.
void serial_init(uint8_t (*realtime)(char));

// A line without its end, once it is whole; 0 if there is none. Valid until the next call. Of a line that is too long
// the first SERIAL_LINE_MAX - 1 characters, followed by a '\n'.
const char* serial_line(void);

void serial_text(const char* flash_text);  // a string in flash, from PSTR()
void serial_char(char c);                  // waits while the buffer is full

#endif
