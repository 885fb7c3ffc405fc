// The pins of an L298N: PWM on ENA, direction on IN1 and IN2, and the outputs read back where they are wired.
#ifndef LAKE_BRIDGE_H
#define LAKE_BRIDGE_H

#include <stdint.h>

// Off, both inputs low. First thing after a reset.
void bridge_init(void);

// ENA low, then both inputs low: the motor coasts.
void bridge_off(void);

// ENA high with both inputs low: the motor is shorted, if both wires of the inputs are whole. Only after bridge_off.
void bridge_brake(void);

// The inputs for a direction, 1 (extend) or -1 (retract); only while the bridge is off.
void bridge_direct(int8_t direction);

// ENA high for that many of LAKE_PWM_PERIOD counts, at least 1.
void bridge_drive(uint16_t counts);

// Which way the pins drive now, whatever is thought: 0 with ENA low or inputs that are alike.
int8_t bridge_driven(void);

// Nonzero if nothing but the firmware holds ENA high: for some us the pin is an input, which 10 kOhm pull down. Only
// while the bridge is off.
uint8_t bridge_enable_is_free(void);

// Nonzero if both outputs read low. Only with LAKE_BRIDGE_SENSE.
uint8_t bridge_outputs_are_low(void);

// While it drives: nonzero if in the last period of the PWM that was looked at the outputs were not as they are told,
// the driven one high and the other low in its high part, the driven one low after its fall. Has the next period looked
// at. 0 without LAKE_BRIDGE_SENSE.
uint8_t bridge_outputs_contradict(void);

#endif
