// The serial line in the manner of Grbl: a line is a command and gets one `ok` or `error:N`; `?`, `!`, `~` and Ctrl-X
// act at once, without a line's end. Unasked come a CSV row every 100 ms, `ALARM:N` and `[MSG:…]`.
#ifndef LAKE_PROTOCOL_H
#define LAKE_PROTOCOL_H

#include <stdint.h>

#include "board.h"

// Who it is, why it was reset, and the header of the CSV rows.
void protocol_greet(reset_cause_t cause);

// Obeys a real-time character and says nonzero, else 0. For the receiver's interrupt.
uint8_t protocol_realtime(char c);

// Once per tick: obeys a line, tells what there is to tell.
void protocol_turn(void);

#endif
