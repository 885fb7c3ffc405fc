// The motor behind the bridge. Every change of direction and every stop goes through a brake of LAKE_DEAD_TIME_MS; then
// the bridge is off, since a lead screw holds by itself.
#ifndef LAKE_MOTOR_H
#define LAKE_MOTOR_H

#include <stdint.h>

// Bridge off. First thing after a reset.
void motor_init(void);

// Once per ms: what is wanted, direction 1 (extend), -1 (retract) or 0, and duty in counts of LAKE_PWM_PERIOD. It is
// applied once the brake has run out.
void motor_tick(int8_t direction, uint16_t counts);

// What the bridge drives now; 0 while braking or off.
int8_t motor_direction(void);
uint16_t motor_counts(void);

#endif
