// Whether the motor may be driven now: the safety relay, which is the second way to switch it off, and what must be
// seen before the first motion after a reset. At rest and after a fault the relay is open.
#ifndef LAKE_POWER_H
#define LAKE_POWER_H

#include <stdint.h>

typedef enum {
  POWER_FINE,
  POWER_RELAY,  // there is a supply behind the relay although it is open
  POWER_BRIDGE  // the motor moved or took current with ENA low
} power_fault_t;

void power_init(void);

// Once per ms: whether something is to move, and whether there is a fault, at which the relay opens at once.
void power_tick(uint8_t is_wanted, uint8_t is_fault);

// Nonzero while the relay is closed and everything has been seen: until then what is wanted waits.
uint8_t power_is_ready(void);

power_fault_t power_fault(void);
void power_forgive(void);  // the checks are made anew

#endif
