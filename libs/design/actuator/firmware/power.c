#include "power.h"

#include "analog.h"
#include "board.h"
#include "config.h"
#include "motor.h"
#include "portable.h"

#define OPEN_MS 500   // after which an open relay leaves no supply: contacts, and the capacitor behind them
#define CLOSE_MS 120  // until the contacts no longer bounce and the supply is there
#define IDLE_MS 500   // for which it stays closed after a motion

// Nothing may move with ENA at 0 % and the inputs set, whichever way. A current shows at once; a movement lags by the
// motor's time constant and the slow stroke's, which begins with a single reading: noise of 5 counts must not look like
// a movement.
#define SETTLE_MS (LAKE_CURRENT_SENSE ? 0 : 100)  // three times the slow stroke's lag, then …
#define PROBE_MS (LAKE_CURRENT_SENSE ? 30 : 200)  // … for each direction
#define PROBES_MS (SETTLE_MS + 2 * PROBE_MS)
#define PROBE_MA 250
#define PROBE_UM 500
#define CAN_SEE_MOTION (LAKE_FEEDBACK || LAKE_CURRENT_SENSE)

static struct {
  uint16_t since_ms;  // the relay's last change
  uint16_t idle_ms;
  uint8_t is_closed, was_seen_open;
  uint16_t probed_ms;
  uint8_t fault;
  int32_t from_um;
} p;

void power_init(void) {
  memset(&p, 0, sizeof p);
  p.is_closed = !LAKE_RELAY;
  power_forgive();
}

void power_forgive(void) {
  p.fault = POWER_FINE;
  p.probed_ms = CAN_SEE_MOTION ? 0 : PROBES_MS;
}

static void switch_relay(uint8_t is_closed) {
  if (p.is_closed == is_closed) return;
  p.is_closed = is_closed;
  p.since_ms = 0;
  p.was_seen_open = 0;
}

static void watch_relay(uint8_t is_wanted, uint8_t is_fault) {
  p.idle_ms = is_wanted ? 0 : p.idle_ms < IDLE_MS ? p.idle_ms + 1 : p.idle_ms;
  if (p.since_ms < OPEN_MS) ++p.since_ms;
  if (!p.is_closed && p.since_ms >= OPEN_MS) {
    p.was_seen_open = !analog_has_supply();
    if (!p.was_seen_open) p.fault = POWER_RELAY;
  }
  if (is_fault || p.fault != POWER_FINE || p.idle_ms >= IDLE_MS)
    switch_relay(0);
  else if (is_wanted && p.was_seen_open)
    switch_relay(1);
  board_close_relay(p.is_closed);
  analog_expect_supply(p.is_closed && p.since_ms >= CLOSE_MS - 40);
}

static uint8_t is_on(void) {
  return p.is_closed && (!LAKE_RELAY || p.since_ms >= CLOSE_MS);
}

static int8_t probe_direction(void) {
  if (p.probed_ms <= SETTLE_MS || p.probed_ms >= PROBES_MS) return 0;
  return p.probed_ms <= SETTLE_MS + PROBE_MS ? 1 : -1;
}

static void probe(void) {
  if (p.probed_ms <= SETTLE_MS) p.from_um = analog_slow_um();
  ++p.probed_ms;
  motor_probe(probe_direction());
  const int32_t way_um = analog_slow_um() - p.from_um;
  const int16_t ma = analog_current_ma();
  if (way_um > PROBE_UM || way_um < -PROBE_UM || ma > PROBE_MA || ma < -PROBE_MA) p.fault = POWER_BRIDGE;
}

void power_tick(uint8_t is_wanted, uint8_t is_fault) {
  if (LAKE_RELAY) watch_relay(is_wanted, is_fault);
  if (is_wanted && !is_fault && is_on() && p.probed_ms < PROBES_MS)
    probe();
  else if (p.probed_ms < PROBES_MS) {
    motor_probe(0);
    p.probed_ms = 0;
  }
}

uint8_t power_is_ready(void) {
  return is_on() && p.probed_ms >= PROBES_MS && p.fault == POWER_FINE;
}

power_fault_t power_fault(void) {
  return (power_fault_t)p.fault;
}
