// Bridge, end stops, serial line of the firmware's portable part where it runs on a PC as a shared library, one per
// stroke table.
#include "host_board.h"

#include <string.h>

#include "board.h"
#include "bridge.h"
#include "config.h"
#include "serial.h"

host_board_t host_board;

static void set(int bridge, int enabled, int8_t direction) {
  host_board.bridge = bridge;
  host_board.enabled = enabled;
  host_board.direction = direction;
  host_board.in1 = direction > 0;
  host_board.in2 = direction < 0;
}

void bridge_init(void) {
  set(HOST_OFF, 0, 0);
}
void bridge_off(void) {
  set(HOST_OFF, 0, 0);
}
void bridge_brake(void) {
  set(HOST_BRAKE, LAKE_PWM_PERIOD, 0);
}
void bridge_direct(int8_t direction) {
  host_board.shorted |= host_board.bridge != HOST_OFF;
  set(HOST_OFF, 0, direction);
}
void bridge_drive(uint16_t counts) {
  set(HOST_DRIVE, counts, (int8_t)host_board.direction);
  host_board.counts = counts;
}
int8_t bridge_driven(void) {
  return (int8_t)(host_board.bridge == HOST_DRIVE ? host_board.direction : 0);
}
uint8_t bridge_enable_is_free(void) {
  return !host_board.enable_is_held;
}
uint8_t bridge_outputs_are_low(void) {
  if (host_board.output_is_stuck) return 0;
  const int is_enabled = host_board.enable_is_held || host_board.enabled > 0;
  return !(is_enabled && (host_board.in1 || host_board.in2 || host_board.in1_is_high || host_board.in2_is_high));
}
uint8_t bridge_outputs_contradict(void) {
  return LAKE_BRIDGE_SENSE && host_board.outputs_contradict;
}

uint32_t portable_block(void) {
  return host_board.blocked++;
}
void portable_restore(uint32_t what) {
  host_board.blocked = what;
}

void board_close_relay(uint8_t is_closed) {
  host_board.relay = is_closed;
}

uint8_t board_end_stops(void) {
  return host_board.open & (LAKE_BUTTON ? 0xFF : END_STOP_RETRACT | END_STOP_EXTEND);
}
uint16_t board_analog(uint8_t channel) {
  return host_board.adc[channel];
}

int16_t serial_read(void) {
  if (host_board.received_tail == host_board.received_head) return -1;
  return host_board.received[host_board.received_tail++];
}
void serial_write(char c) {
  if (host_board.said_length < sizeof host_board.said) host_board.said[host_board.said_length++] = c;
}

uint8_t serial_has_room(void) {
  return 1;
}

uint8_t board_is_late(void) {
  return host_board.is_late;
}

uint8_t board_can_remember(void) {
  return 1;
}
uint8_t board_remembered(uint8_t place) {
  return host_board.remembered[place];
}
void board_remember(uint8_t place, uint8_t number) {
  host_board.remembered[place] = number;
}
