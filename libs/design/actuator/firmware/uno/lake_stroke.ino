// Drives a knee exoskeleton's linear actuator through the stroke program of stroke_table.h: an Arduino UNO with an
// L298N. Open this folder's lake_stroke.ino with the Arduino IDE, choose the board "Arduino UNO" and upload. Wiring,
// commands, error codes and safety: README.txt in this folder.
extern "C" {
#include "firmware.h"
}

void setup() {
  firmware_begin();
}

void loop() {
  firmware_turn();
}
