#include "firmware.h"

#include "analog.h"
#include "board.h"
#include "controller.h"
#include "end_stops.h"
#include "motor.h"
#include "protocol.h"
#include "serial.h"

void firmware_begin(void) {
  motor_init();
  board_init();
  end_stops_init();
  analog_init();
  controller_init();
  serial_init(protocol_realtime);
  board_start(controller_tick);
  protocol_greet(board_reset_cause());
}

void firmware_turn(void) {
  if (!board_wait()) return;
  protocol_turn();
  controller_remember();
}
