#include "motor.h"

#include "bridge.h"
#include "config.h"
#include "portable.h"

#define OUTPUT_WRONG_MS 3
#define DRIVE_WRONG_MS 30  // longer than a supply that is off needs to be told as such: analog.c

static struct {
  int8_t driving, probing;
  uint16_t counts;
  uint16_t dead_left_ms;
  uint8_t brakes;  // in this dead time
  uint8_t wrong_ms;
  uint8_t is_wrong;
} m;
static volatile uint8_t is_cut;

void motor_init(void) {
  bridge_init();
  memset(&m, 0, sizeof m);
  is_cut = 0;
}

static void be_wrong(void) {
  bridge_off();
  m.driving = 0;
  m.counts = 0;
  m.is_wrong = 1;
}

void motor_stop(void) {
  bridge_off();
  m.driving = 0;
  m.counts = 0;
  m.wrong_ms = 0;
  m.dead_left_ms = LAKE_DEAD_TIME_MS;
  m.brakes = LAKE_BRIDGE_SENSE;
}

void motor_cut(void) {
  bridge_off();
  is_cut = 1;
}

// Both outputs low, or the bridge is off in the same tick.
static void brake(void) {
  bridge_brake();
  if (bridge_outputs_are_low()) return;
  m.brakes = 0;
  be_wrong();
}

// At rest an output is high only by a transistor that is shorted, or by a bridge that is on.
static void watch_outputs(void) {
  if (!LAKE_BRIDGE_SENSE || bridge_outputs_are_low())
    m.wrong_ms = 0;
  else if (++m.wrong_ms >= OUTPUT_WRONG_MS)
    be_wrong();
}

// Driven, the outputs follow the PWM, but for a broken wire, a transistor that is shorted, or no supply.
static void watch_drive(void) {
  if (!bridge_outputs_contradict())
    m.wrong_ms = 0;
  else if (++m.wrong_ms >= DRIVE_WRONG_MS)
    be_wrong();
}

static void begin(int8_t direction) {
  if (!bridge_enable_is_free()) {
    be_wrong();
    return;
  }
  bridge_direct(direction);
  m.driving = direction;
}

static void drive(int8_t direction, uint16_t counts) {
  if (m.driving == direction && m.counts == counts) return;
  if (m.driving == 0) begin(direction);
  if (m.is_wrong) return;
  ATOMICALLY {
    if (!is_cut) bridge_drive(counts);
  }
  m.counts = counts;
}

void motor_tick(int8_t direction, uint16_t counts) {
  if (counts == 0 || m.is_wrong) direction = 0;
  const uint8_t was_cut = is_cut;
  is_cut = 0;
  if (m.driving != 0 && (was_cut || direction != m.driving)) {
    motor_stop();
    return;
  }
  if (m.dead_left_ms > 0) {
    if (m.brakes) brake();
    if (--m.dead_left_ms > 0) return;
    bridge_off();
  }
  if (m.driving == 0) watch_outputs();
  if (direction != 0 && !m.is_wrong) drive(direction, counts);
  if (m.driving != 0) watch_drive();
}

void motor_probe(int8_t direction) {
  if (m.driving != 0 || m.dead_left_ms > 0 || direction == m.probing) return;
  m.probing = direction;
  if (direction != 0 && !bridge_enable_is_free())
    be_wrong();
  else
    bridge_direct(direction);
}

int8_t motor_direction(void) {
  return m.driving;
}
uint16_t motor_counts(void) {
  return m.counts;
}
uint8_t motor_bridge_is_wrong(void) {
  return m.is_wrong;
}
void motor_forgive(void) {
  m.is_wrong = m.wrong_ms = 0;
}
uint8_t motor_kept(kept_t what) {
  return kept_pass(&m, sizeof m, what);
}
