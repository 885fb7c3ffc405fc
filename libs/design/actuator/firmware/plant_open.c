#include "config.h"
#include "divide.h"
#include "motor.h"
#include "plant.h"
#include "portable.h"

static struct {
  int32_t stroke_nm;         // um/s during one ms are nm
  uint32_t way_drift_nm;     // what the tolerance of the speed allows
  uint32_t lag_drift_nm[2];  // what lag allows: behind by speeding up, ahead by slowing down
  int32_t last_um_s;
} p;

uint32_t plant_node_um_s(uint8_t retracts, uint8_t node) {
  return pgm_read_dword(&lake_speed_um_s[retracts][node]);
}

int32_t plant_planned_um(void) {
  return thousandth(p.stroke_nm);
}

int32_t plant_stroke_um(void) {
  return plant_planned_um();
}

uint32_t plant_drift_um(void) {
  // Neither is more than LAKE_DRIFT_MOST_NM and a step: their sum is below 2^31.
  const uint32_t lag_nm = p.lag_drift_nm[0] > p.lag_drift_nm[1] ? p.lag_drift_nm[0] : p.lag_drift_nm[1];
  return (uint32_t)thousandth((int32_t)(p.way_drift_nm + lag_nm));
}

void plant_know(int32_t um) {
  p.stroke_nm = um * 1000;
  p.way_drift_nm = LAKE_DRIFT_START_UM * 1000L;
  p.lag_drift_nm[0] = p.lag_drift_nm[1] = 0;
}

uint8_t plant_contradicts(int32_t um) {
  (void)um;
  return 0;
}

void plant_reset(void) {}
void plant_begin(void) {}

motion_t plant_follow(int32_t velocity_um_s, uint16_t counts) {
  return motion_of((int8_t)((velocity_um_s > 0) - (velocity_um_s < 0)), counts, velocity_um_s);
}

// Until the bridge does what is asked for, so that no brake costs stroke.
uint8_t plant_waits(const motion_t* wanted) {
  return motor_direction() != wanted->direction;
}

uint32_t plant_waited_ms(void) {
  return 0;
}

int8_t plant_side_of_start(void) {
  return LAKE_POSITION_MS > 0 ? 1 : -1;
}

uint8_t plant_has_arrived(int8_t side) {
  (void)side;
  return machine.clock_ms >= machine.end_ms;
}

// What the tolerances allow in this ms: a part of the way and what it may be less, and what the motor's lag loses as
// the speed rises, gains as it falls.
uint8_t plant_turn(const motion_t* driven, const motion_t* wanted, int32_t planned_um_s) {
  (void)wanted;
  (void)planned_um_s;
  const int32_t velocity_um_s = driven->velocity_um_s;
  const uint32_t way_nm = velocity_um_s < 0 ? -velocity_um_s : velocity_um_s;
  const int32_t change = velocity_um_s - p.last_um_s;
  p.last_um_s = velocity_um_s;
  p.stroke_nm += velocity_um_s;
  uint32_t* const lag = &p.lag_drift_nm[change < 0];
  if (*lag < LAKE_DRIFT_MOST_NM) *lag += (uint32_t)(change < 0 ? -change : change) * LAKE_LAG_MS;
  if (p.way_drift_nm < LAKE_DRIFT_MOST_NM)
    p.way_drift_nm += driven->spread_um_s + (way_nm * LAKE_DRIFT_PER_1024 + 1023) / 1024;
  return 0;
}

uint8_t plant_kept(kept_t what) {
  return kept_pass(&p, sizeof p, what);
}
