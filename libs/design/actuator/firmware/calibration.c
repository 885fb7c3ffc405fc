#include "motor.h"
#include "plant.h"
#include "program.h"
#include "stroke_table.h"

#if LAKE_SEGMENT_COUNT == 0

// No duty table, so no speed, no stroke and no limit but the end stops.
void program_init(void) {}
void program_reset(void) {}
reply_t program_take_run(void) {
  return REPLY_NO_PROGRAM;
}
reply_t program_take_home(void) {
  return REPLY_NO_PROGRAM;
}
reply_t program_take_zero(void) {
  return REPLY_NO_PROGRAM;
}
motion_t program_jog(int8_t direction, uint16_t counts) {
  return motion_of(direction, counts, 0);
}
uint8_t program_is_measured(int8_t direction, uint16_t counts) {
  (void)direction;
  (void)counts;
  return 1;
}
motion_t program_run(void) {
  return motion_rest();
}
motion_t program_home(void) {
  return motion_rest();
}
uint8_t program_soft_limit_ahead(int8_t direction) {
  (void)direction;
  return 0;
}
uint8_t program_hard_limit_ahead(int8_t direction) {
  (void)direction;
  return 0;
}
motion_t program_careful(motion_t motion) {
  return motion;
}
uint8_t program_kept(kept_t what) {
  (void)what;
  return 1;
}
uint8_t program_stop_contradicts_stroke(void) {
  return 0;
}
uint8_t program_stop_is_stuck(void) {
  return 0;
}
void program_keep_books(const motion_t* driven, const motion_t* wanted) {
  (void)driven;
  (void)wanted;
}
int32_t plant_planned_um(void) {
  return 0;
}
uint32_t plant_drift_um(void) {
  return 0;
}
uint8_t plant_waits(const motion_t* wanted) {
  return motor_direction() != wanted->direction;
}
uint32_t plant_waited_ms(void) {
  return 0;
}

#endif
