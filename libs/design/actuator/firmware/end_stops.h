// The two end stops, and the button that is held while something moves: pressed, or let go, at the first ms that sees
// them so, otherwise only when that lasts.
#ifndef LAKE_END_STOPS_H
#define LAKE_END_STOPS_H

#include <stdint.h>

#include "board.h"

// They count as pressed, and as let go, until they have been seen closed.
void end_stops_init(void);

uint8_t end_stops_interrupt(void);  // once per ms: bits as in board.h
void end_stops_turn(void);          // takes them for this turn of the main loop
uint8_t end_stops_pressed(void);    // without the button
uint8_t end_stops_button_is_released(void);

#endif
