// The closed loop on the stroke: which speed brings the actuator to its plan, which duty gives that speed, and whether
// the actuator does what it is driven to do. Strokes in um, speeds in um/s, positive extends.
#ifndef LAKE_FOLLOW_H
#define LAKE_FOLLOW_H

#include <stdint.h>

// The duty table's greatest speed at a node of duty: kept once, as it takes 0.5 KB of flash.
uint32_t follow_node_um_s(uint8_t retracts, uint8_t node);

void follow_begin(void);  // of a program: forgets what was learnt

// Takes the place where the rod is now for the one to watch from: a fault was seen to, by hand perhaps.
void follow_watch_begin(void);

// Once per ms: feed-forward of the plan's speed and PI on the error, within what the duty table has. 0 is rest.
int32_t follow_speed(int32_t planned_um, int32_t planned_um_s, int32_t measured_um);

// The inverse of the duty table.
uint16_t follow_counts(int32_t speed_um_s);

// Before follow_speed: whether the bridge gives all that the supply has. Then no error is summed up.
void follow_limit(uint8_t is_limited);

// Nonzero where the actuator is behind its plan and the motor has no more speed: the plan has to wait for it.
uint8_t follow_lags(void);

enum {
  FOLLOW_FINE,
  FOLLOW_PROVEN,  // it has moved the way it is driven
  FOLLOW_STILL,   // driven, and not seen to go on
  FOLLOW_NO_MOTION,
  FOLLOW_WRONG_WAY,
  FOLLOW_RUNAWAY
};

// Once per ms: the speed that the bridge drives by the duty table, 0 if it does not drive; the stroke as it is
// measured, and the slow stroke, where small movements count.
uint8_t follow_watch(int32_t driven_um_s, int32_t measured_um, int32_t slow_um);

#endif
