// The board: Arduino UNO (ATmega328P, 16 MHz) with an L298N. What belongs to one stroke program is in stroke_table.h.
#ifndef LAKE_CONFIG_H
#define LAKE_CONFIG_H

#ifndef F_CPU
#define F_CPU 16000000UL
#endif

#include <avr/io.h>
#include <stdint.h>

#include "stroke_table.h"

// L298N, channel A. A 10 kOhm resistor from ENA to ground keeps the bridge off while the UNO starts or is unplugged.
#define ENA_BIT PB1  // D9, output A of timer 1
#define IN1_BIT PD7  // D7
#define IN2_BIT PB0  // D8

// End stops: normally closed switches to ground with the internal pull-ups. A pressed switch, a broken wire and a
// missing switch all read high.
#define RETRACT_STOP_BIT PD2  // D2, at the shortest stroke
#define EXTEND_STOP_BIT PD3   // D3, at the longest stroke
#define DEBOUNCE_MS 3         // both to press and to release

// A0: optional potentiometer. It is reported, never used for control.
#define ADC_CHANNEL 0

#define STATUS_PERIOD_MS 100u
#define JOG_MAX_MS 10000u
#define SOFT_LIMIT_SLACK_UM 50  // rounding of the table, not room to move

#endif
