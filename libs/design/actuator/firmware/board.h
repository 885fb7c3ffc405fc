// The rest of a board: end stops, tick, potentiometer, watchdog.
#ifndef LAKE_BOARD_H
#define LAKE_BOARD_H

#include <stdint.h>

typedef enum { RESET_BY_POWER_OR_BUTTON, RESET_BY_WATCHDOG, RESET_BY_LOW_VOLTAGE } reset_cause_t;

// End stops and analogue inputs; nothing runs yet.
void board_init(void);

// Interrupts on, board_interrupt once per ms inside the timer's, which nothing interrupts; watchdog of some 0.1 s.
void board_start(void);
void board_interrupt(void);  // guard.c: no pointer in RAM that a bit could turn

// Nonzero if a ms waits to be done; board_done ends it and feeds the watchdog, which so is fed only while interrupt and
// controller both run. To sleep is to wait for an interrupt, unless a ms waits.
uint8_t board_is_due(void);
void board_done(void);
void board_sleep(void);

enum { END_STOP_RETRACT = 1, END_STOP_EXTEND = 2, BUTTON_RELEASED = 4, SWITCHES = 3 };

// Bits of the end stops, and of the button that is held, that are open now. Pins are read four times within 20 us and
// must agree: the bridge's spikes are shorter.
uint8_t board_end_stops(void);

void board_close_relay(uint8_t is_closed);  // the safety relay, open after a reset

// A0, A1, A2.
enum { ANALOG_POTENTIOMETER, ANALOG_CURRENT, ANALOG_SUPPLY, ANALOG_COUNT };

// The last reading: the sum of four conversions, 0..4092. All wired channels are read once per ms.
uint16_t board_analog(uint8_t channel);

// Nonzero once a round of conversions has not ended within its ms, or the main loop is more than LATE_MS behind:
// nothing holds of what rests on time.
uint8_t board_is_late(void);

reset_cause_t board_reset_cause(void);

// Numbers that outlive resets and lost power, 0 on a board that has never kept one there. Writing takes up to 4 ms,
// during which none can be read: board_can_remember is 0.
#define BOARD_REMEMBERED 255
uint8_t board_can_remember(void);
uint8_t board_remembered(uint8_t place);
void board_remember(uint8_t place, uint8_t number);

#ifdef LAKE_SIMULATOR
void board_hang(void);  // the main loop hangs
void board_quit(void);  // ends the simulation
#endif

#endif
