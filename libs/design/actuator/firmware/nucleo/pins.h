// The Nucleo-64's pins by the numbers that its Arduino connectors have, as an UNO's: 0 to 13 are D0 to D13, 14 to 19
// are A0 to A5.
#ifndef LAKE_PINS_H
#define LAKE_PINS_H

#include <stdint.h>

void pin_write(uint8_t pin, uint8_t is_high);
uint8_t pin_read(uint8_t pin);
void pin_mode(uint8_t pin, uint8_t mode);  // MODE_INPUT, …
void pin_pull_up(uint8_t pin);
void pin_alternate(uint8_t pin, uint8_t function);  // which one; MODE_ALTERNATE connects it
void pin_disconnect(uint8_t pin);                   // from it to an output; an input stays one

#endif
