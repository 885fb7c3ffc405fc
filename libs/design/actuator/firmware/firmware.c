#include "firmware.h"

#include "analog.h"
#include "board.h"
#include "controller.h"
#include "end_stops.h"
#include "motor.h"
#include "power.h"
#include "protocol.h"
#include "serial.h"

void board_tick(void) {
  controller_tick();
}

realtime_t serial_realtime(char c) {
  return protocol_realtime(c);
}

void firmware_begin(void) {
  motor_init();
  board_init();
  end_stops_init();
  analog_init();
  power_init();
  controller_init();
  serial_init();
  board_start();
  protocol_greet(board_reset_cause());
}

void firmware_turn(void) {
  if (!board_wait()) return;
  protocol_turn();
  controller_remember();
}
