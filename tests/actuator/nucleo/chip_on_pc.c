// In place of the core's instructions, cortex.c.
#include "chip_on_pc.h"

#include "chip.h"
#include "portable.h"

chip_on_pc_t chip_on_pc;

static uint32_t blocked;

uint32_t portable_block(void) {
  return blocked++;
}
void portable_restore(uint32_t what) {
  blocked = what;
}
void chip_sleep(void) {
  chip_on_pc.sleep(chip_on_pc.chip);
}
void chip_allow_interrupts(void) {}
