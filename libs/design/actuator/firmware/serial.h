// Serial line, 115200 baud, 8N1: interrupt-driven in both directions. Not for use inside interrupts.
#ifndef LAKE_SERIAL_H
#define LAKE_SERIAL_H

#include <stdint.h>

// What a real-time character was. Beside those that only stop there is one that also forgets what came before it.
typedef enum { REALTIME_NONE, REALTIME_DONE, REALTIME_FORGET } realtime_t;

void serial_init(void);

// Called for every character inside the receiver's interrupt; what it obeys does not become part of a line.
// protocol.c defines it.
realtime_t serial_realtime(char c);

// The next character that was received, -1 if there is none. SERIAL_FORGET: what was read before belongs to nothing.
// SERIAL_LOST stands where characters were lost.
enum { SERIAL_LOST = 0, SERIAL_FORGET = 0x18 };
int16_t serial_read(void);

uint8_t serial_has_room(void);  // for a line of SERIAL_LINE characters
#define SERIAL_LINE 104         // the longest is the header of a row with everything wired: 97
void serial_write(char c);      // waits while there is no room

#endif
