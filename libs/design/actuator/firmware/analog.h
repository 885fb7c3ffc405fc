// What the analogue inputs tell, of those that stroke_table.h says are wired: the motor's supply, its current, the
// stroke by the actuator's potentiometer; filtered once per ms, and whether they can be true.
#ifndef LAKE_ANALOG_H
#define LAKE_ANALOG_H

#include <stdint.h>

enum {
  ANALOG_NO_SUPPLY = 1,      // outside its limits: off, sagging, or the sense wire
  ANALOG_NO_WIPER = 2,       // the potentiometer reads what it cannot: lost, shorted, or it jumps
  ANALOG_OVERCURRENT = 4,    // a short, at once
  ANALOG_STALL_CURRENT = 8,  // less, but for long
  ANALOG_NO_INRUSH = 16,     // the motor took no current when it was started: it, its supply or the sense wire
  ANALOG_STRAY_CURRENT = 32  // current although the bridge is off
};

void analog_init(void);

// Once per ms from the interrupt: nonzero while the current is a short's.
uint8_t analog_interrupt(void);

// Once per ms from the main loop; `counts`: what the bridge drives, 0 if it does not.
void analog_tick(uint16_t counts);

// Bits of what is wrong now.
uint8_t analog_faults(void);

// Whether the supply should be there: behind a relay that is open it is not. At first it should.
void analog_expect_supply(uint8_t is_on);
uint8_t analog_has_supply(void);  // a fifth of it, at least

// Of a closed loop that measures it: the duty that gives at this supply what `counts` give at the nominal one, at most
// all of it. Else `counts`.
uint16_t analog_at_supply(uint16_t counts);

int32_t analog_stroke_um(void);           // 0 without a potentiometer
int32_t analog_slow_um(void);             // the slow stroke: later by 2^SLOW ms, with less noise
int16_t analog_current_ma(void);          // 0 without a sensor; from what it reads at rest
uint8_t analog_is_without_current(void);  // for NO_CURRENT_MS, although the bridge drives

#endif
