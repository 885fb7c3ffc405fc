// What cannot wait for the main loop: the motor is off within the ms at an end stop that it is driven towards, once the
// button is let go, at a short, and once the main loop or the converter is late. It looks at the pins, not at what the
// controller thinks; what it came from the controller finds out by itself.
#include "analog.h"
#include "board.h"
#include "bridge.h"
#include "end_stops.h"
#include "motor.h"

void board_interrupt(void) {
  const uint8_t open = end_stops_interrupt();
  const uint8_t is_short = analog_interrupt();
  const int8_t driven = bridge_driven();
  const uint8_t ends = driven > 0   ? END_STOP_EXTEND | BUTTON_RELEASED
                       : driven < 0 ? END_STOP_RETRACT | BUTTON_RELEASED
                                    : 0;
  if ((open & ends) || is_short || board_is_late()) motor_cut();
}
