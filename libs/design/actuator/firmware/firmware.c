#include "firmware.h"

#include "analog.h"
#include "board.h"
#include "controller.h"
#include "end_stops.h"
#include "guard.h"
#include "motor.h"
#include "power.h"
#include "protocol.h"
#include "serial.h"

void board_interrupt(void) {
  guard_interrupt();
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
  protocol_greet(board_reset_cause());
  board_start();
}

void firmware_turn(void) {
  for (; board_is_due(); board_done()) controller_turn();
  protocol_turn();
  controller_remember();
  board_sleep();
}
