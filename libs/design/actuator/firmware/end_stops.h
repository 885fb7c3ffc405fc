// The two end stops: pressed at the first tick that sees them so, released only when that lasts.
#ifndef LAKE_END_STOPS_H
#define LAKE_END_STOPS_H

#include <stdint.h>

#include "board.h"

// Both count as pressed until they have been seen closed.
void end_stops_init(void);
void end_stops_tick(void);  // once per ms

// Bits of those that are pressed, as in board.h.
uint8_t end_stops_pressed(void);

#endif
