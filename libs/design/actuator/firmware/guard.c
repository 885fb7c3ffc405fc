#include "guard.h"

#include "analog.h"
#include "board.h"
#include "bridge.h"
#include "end_stops.h"
#include "motor.h"

void guard_interrupt(void) {
  const uint8_t open = end_stops_interrupt();
  const uint8_t is_short = analog_interrupt();
  const int8_t driven = bridge_driven();
  const uint8_t ends = driven > 0   ? END_STOP_EXTEND | BUTTON_RELEASED
                       : driven < 0 ? END_STOP_RETRACT | BUTTON_RELEASED
                                    : 0;
  if ((open & ends) || is_short || board_is_late()) motor_cut();
}
