// The serial line in the manner of Grbl: a line is a command and gets one `ok` or `error:N`; `?`, `!` and Ctrl-X act at
// once, without a line's end; the last two also forget the lines that wait. Unasked come a CSV row every 100 ms,
// `ALARM:N` and `[MSG:…]`. Every line that is said has a check sum, and so must those that are obeyed, but for
// `stop` and `header`: what a terminal, noise or another program says starts nothing.
#ifndef LAKE_PROTOCOL_H
#define LAKE_PROTOCOL_H

#include <stdint.h>

#include "board.h"

// Will say who it is, why it was reset, the header of the CSV rows, and a fault that stays.
void protocol_greet(reset_cause_t why);

// Over and over: says a line at most, if there is room to send it whole; with nothing to say, obeys one.
void protocol_turn(void);

#endif
