// Drives a knee exoskeleton's linear actuator through the stroke program of stroke_table.h: a Nucleo-64 (STM32F401RE,
// F411RE or F446RE) with an L298N or a BTS7960. How it is compiled and uploaded, wiring, commands, error codes and
// safety: README.txt in this folder.
#include "firmware.h"

int main(void) {
  firmware_begin();
  for (;;) firmware_turn();
}
