// The pins of an L298N: PWM on ENA, direction on IN1 and IN2.
#ifndef LAKE_BRIDGE_H
#define LAKE_BRIDGE_H

#include <stdint.h>

// Off, both inputs low. First thing after a reset.
void bridge_init(void);

// ENA low: the motor is free.
void bridge_off(void);

// Both inputs low, ENA high: the motor is shorted. The inputs change while ENA is low.
void bridge_brake(void);

// The inputs for a direction, 1 (extend) or -1 (retract); only while the bridge is off.
void bridge_direct(int8_t direction);

// ENA high for that many of LAKE_PWM_PERIOD counts, at least 1.
void bridge_drive(uint16_t counts);

#endif
