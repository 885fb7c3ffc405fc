// Without the Arduino IDE:
//   avr-gcc -mmcu=atmega328p -std=gnu99 -Os -flto *.c -o lake_stroke.elf
//   avr-objcopy -O ihex lake_stroke.elf lake_stroke.hex
//   avrdude -c arduino -p m328p -P /dev/ttyACM0 -b 115200 -U flash:w:lake_stroke.hex
#ifndef ARDUINO

#include "firmware.h"

int main(void) {
  firmware_begin();
  for (;;) firmware_turn();
}

#endif
