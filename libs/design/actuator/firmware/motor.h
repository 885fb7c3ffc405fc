// The motor behind the bridge. A stop is ENA low first, then both inputs low: the motor coasts, and the screw holds it.
// To brake is to switch ENA on, which drives where a wire of the inputs is broken: it is braked only where the outputs
// are read back and both are low. Between a stop and whatever comes next lie LAKE_DEAD_TIME_MS.
#ifndef LAKE_MOTOR_H
#define LAKE_MOTOR_H

#include <stdint.h>

#include "kept.h"

// Bridge off. First thing after a reset.
void motor_init(void);

// Once per ms: what is wanted, direction 1 (extend), -1 (retract) or 0, and duty in counts of LAKE_PWM_PERIOD. It is
// applied once the dead time has run out.
void motor_tick(int8_t direction, uint16_t counts);

void motor_stop(void);  // whatever is thought to be driven

// From an interrupt: off at once, and nothing drives until the next motor_tick has taken that for a stop.
void motor_cut(void);

// In place of motor_tick while the motor rests: the inputs for a direction with ENA low, where nothing may move; 0 ends
// it.
void motor_probe(int8_t direction);

// What the bridge drives now; 0 while it stops or is off.
int8_t motor_direction(void);
uint16_t motor_counts(void);

// Nonzero once the bridge was found to do what it was not told: ENA held high by a jumper or a wire, an output that is
// high at rest or while it is braked. It is off then, until motor_forgive.
uint8_t motor_bridge_is_wrong(void);
void motor_forgive(void);

uint8_t motor_kept(kept_t what);

#endif
