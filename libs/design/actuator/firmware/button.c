#include "button.h"

#include "board.h"
#include "config.h"

static uint8_t is_held, was_released, other_for_ms;

void button_init(void) {
  is_held = was_released = other_for_ms = 0;
}

void button_tick(void) {
  const uint8_t now = board_button();
  if (now == is_held) {
    other_for_ms = 0;
  } else if (++other_for_ms >= (now ? BUTTON_PRESSED_MS : BUTTON_RELEASED_MS)) {
    is_held = now;
    other_for_ms = 0;
  }
  if (!now && !is_held) was_released = 1;
}

uint8_t button_is_held(void) {
  return is_held;
}
uint8_t button_was_released(void) {
  return was_released;
}
