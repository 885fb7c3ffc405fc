#include "guard.h"

#include "analog.h"
#include "board.h"
#include "bridge.h"
#include "end_stops.h"
#include "motor.h"

void guard_interrupt(void) {
  const uint8_t pressed = end_stops_interrupt();
  const uint8_t is_short = analog_interrupt();
  const int8_t driven = bridge_driven();
  const uint8_t ahead = driven > 0 ? END_STOP_EXTEND : driven < 0 ? END_STOP_RETRACT : 0;
  if ((pressed & ahead) || is_short || board_is_late()) motor_cut();
}
