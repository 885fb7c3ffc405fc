// The two end stops: pressed at the first ms that sees them so, released only when that lasts.
#ifndef LAKE_END_STOPS_H
#define LAKE_END_STOPS_H

#include <stdint.h>

#include "board.h"

// Both count as pressed until they have been seen closed.
void end_stops_init(void);

uint8_t end_stops_interrupt(void);  // once per ms: bits of those that are pressed, as in board.h
void end_stops_turn(void);          // takes them for this turn of the main loop
uint8_t end_stops_pressed(void);

#endif
