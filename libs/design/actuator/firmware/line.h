// Lines with a check sum, in both directions: `text*HHHH`, where HHHH is the CRC-16/MCRF4XX of the text (polynomial
// 0x1021 from the lowest bit on, from 0xFFFF; avr-libc's _crc_ccitt_update) in hexadecimal digits. Not for use inside
// interrupts.
#ifndef LAKE_LINE_H
#define LAKE_LINE_H

#include <stdint.h>

#define LINE_MAX 40

typedef enum {
  LINE_NONE,     // no whole line has come
  LINE_FRAMED,   // with its check sum, which is right
  LINE_PLAIN,    // without one
  LINE_DAMAGED,  // a wrong check sum, or characters that no line has
  LINE_TOO_LONG
} line_kind_t;

// The next whole line that was received. Its text without the check sum is valid until the next call.
line_kind_t line_read(const char** text);

// What is said; a '\n' ends the line with its check sum.
void line_char(char c);
void line_text(const char* flash_text);  // a string in flash, from PSTR()

#endif
