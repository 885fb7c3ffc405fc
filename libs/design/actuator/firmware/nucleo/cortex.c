// The core's own instructions, so that everything else is C that a PC compiles as well.
#include "chip.h"
#include "portable.h"

uint32_t portable_block(void) {
  uint32_t was;
  __asm volatile("mrs %0, primask\n\tcpsid i" : "=r"(was) : : "memory");
  return was;
}

void portable_restore(uint32_t what) {
  __asm volatile("msr primask, %0" : : "r"(what) : "memory");
}

void chip_sleep(void) {
  __asm volatile("wfi" : : : "memory");
}

void chip_allow_interrupts(void) {
  __asm volatile("cpsie i" : : : "memory");
}
