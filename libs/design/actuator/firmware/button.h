// The wearer's hold-to-run button, to ground: a broken wire reads as released.
#ifndef LAKE_BUTTON_H
#define LAKE_BUTTON_H

#include <stdint.h>

void button_init(void);
void button_tick(void);  // once per ms

uint8_t button_is_held(void);
uint8_t button_was_released(void);  // since the reset: else its wire may be at ground

#endif
