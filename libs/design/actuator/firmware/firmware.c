#include "firmware.h"

#include "analog.h"
#include "board.h"
#include "controller.h"
#include "end_stops.h"
#include "motor.h"
#include "power.h"
#include "protocol.h"
#include "serial.h"

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

// Without the Arduino IDE:
//   avr-gcc -mmcu=atmega328p -std=gnu99 -Os -flto *.c -o lake_stroke.elf
//   avr-objcopy -O ihex lake_stroke.elf lake_stroke.hex
//   avrdude -c arduino -p m328p -P /dev/ttyACM0 -b 115200 -U flash:w:lake_stroke.hex
#ifndef ARDUINO
int main(void) {
  firmware_begin();
  for (;;) firmware_turn();
}
#endif
