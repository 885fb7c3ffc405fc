#include "motor.h"

#include "bridge.h"
#include "config.h"

static int8_t driving;
static uint16_t driving_counts;
static uint16_t brake_left_ms;

void motor_init(void) {
  bridge_init();
  driving = 0;
  driving_counts = 0;
  brake_left_ms = 0;
}

static void start_brake(void) {
  bridge_brake();
  driving = 0;
  driving_counts = 0;
  brake_left_ms = LAKE_DEAD_TIME_MS;
}

static void drive(int8_t direction, uint16_t counts) {
  if (driving == direction && driving_counts == counts) return;
  if (driving == 0) bridge_direct(direction);
  bridge_drive(counts);
  driving = direction;
  driving_counts = counts;
}

void motor_tick(int8_t direction, uint16_t counts) {
  if (counts == 0) direction = 0;
  if (driving != 0 && direction != driving) {
    start_brake();
    return;
  }
  if (brake_left_ms > 0) {
    if (--brake_left_ms > 0) return;
    bridge_off();
  }
  if (direction != 0) drive(direction, counts);
}

int8_t motor_direction(void) {
  return driving;
}
uint16_t motor_counts(void) {
  return driving_counts;
}
