// How the stroke is known, and what a program's plan asks of the motor: plant_open.c, where the stroke is planned, or
// plant_pot.c, where a potentiometer measures it. The sketch has the one that its stroke_table.h is for. Strokes
// in um, speeds in um/s, positive extends.
#ifndef LAKE_PLANT_H
#define LAKE_PLANT_H

#include "state.h"

int32_t plant_planned_um(void);
int32_t plant_stroke_um(void);          // where the actuator is, as well as that is known …
uint32_t plant_drift_um(void);          // … and how far it may be from there
void plant_know(int32_t um);            // it is there, by an end stop or by whoever has measured it
uint8_t plant_contradicts(int32_t um);  // whether what is measured is far from a place that is known otherwise

void plant_reset(void);                                         // of a fault: whatever moved it meanwhile is none
void plant_begin(void);                                         // of a program: forgets what was learnt
motion_t plant_follow(int32_t velocity_um_s, uint16_t counts);  // for this stretch of the plan

// Whether the clock of what moves stands still in this ms; for how long a program's did so.
uint8_t plant_waits(const motion_t* wanted);
uint32_t plant_waited_ms(void);

// Of homing's last way: on which side of the program's start it begins, 1 below and -1 above, and whether it is there.
int8_t plant_side_of_start(void);
uint8_t plant_has_arrived(int8_t side);

// Once per ms: what the bridge drives, what is wanted of it, the plan's speed. Nonzero once it was seen that the
// actuator moves the way it is driven.
uint8_t plant_turn(const motion_t* driven, const motion_t* wanted, int32_t planned_um_s);

uint8_t plant_kept(kept_t what);

// The duty table's greatest speed at a node of duty: read in one place, as the table takes 0.5 KB of flash.
uint32_t plant_node_um_s(uint8_t retracts, uint8_t node);

#endif
