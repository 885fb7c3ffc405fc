// The stroke program, homing and the limits. A firmware for calibration has no segments and no speeds: it only jogs,
// and no limit holds but the end stops.
#ifndef LAKE_PROGRAM_H
#define LAKE_PROGRAM_H

#include "state.h"

void program_init(void);   // after a reset of the chip
void program_reset(void);  // of a fault

// Answers to requests, asked for only at rest: whether what is known allows it.
reply_t program_take_run(void);
reply_t program_take_home(void);
reply_t program_take_zero(void);

// What a jog's duty gives, and whether the duty table knows that duty.
motion_t program_jog(int8_t direction, uint16_t counts);
uint8_t program_is_measured(int8_t direction, uint16_t counts);

// What is wanted in this ms.
motion_t program_run(void);
motion_t program_home(void);

uint8_t program_soft_limit_ahead(int8_t direction);
uint8_t program_hard_limit_ahead(int8_t direction);  // what a program that runs must not pass

// The same motion, or as slowly as the duty table goes while an end stop behind is pressed and nothing has shown yet
// that the motor turns as it is told.
motion_t program_careful(motion_t motion);

uint8_t program_stop_contradicts_stroke(void);  // pressed, though the stroke is known to be somewhere else
uint8_t program_stop_is_stuck(void);            // pressed although the actuator moved away from it, or pressed by that

// Once per ms: what the bridge drives, and what is wanted of it.
void program_keep_books(const motion_t* driven, const motion_t* wanted);

uint8_t program_kept(kept_t what);

#endif
