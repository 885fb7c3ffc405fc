// Bridge, end stops, serial line of the firmware's portable part where it runs on a PC as a shared library, one per
// stroke table.
#include "host_board.h"

#include <string.h>

#include "board.h"
#include "bridge.h"
#include "serial.h"

host_board_t host_board;

void bridge_init(void) {
  host_board.bridge = HOST_OFF;
  host_board.direction = 0;
}
void bridge_off(void) {
  host_board.bridge = HOST_OFF;
}
void bridge_brake(void) {
  host_board.bridge = HOST_BRAKE;
  host_board.direction = 0;
}
void bridge_direct(int8_t direction) {
  host_board.shorted |= host_board.bridge != HOST_OFF;
  host_board.direction = direction;
}
void bridge_drive(uint16_t counts) {
  host_board.bridge = HOST_DRIVE;
  host_board.counts = counts;
}

uint8_t board_end_stops(void) {
  return host_board.open;
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

uint8_t board_is_late(void) {
  return 0;
}

uint8_t board_remembered(void) {
  return host_board.remembered;
}
void board_remember(uint8_t number) {
  host_board.remembered = number;
}
