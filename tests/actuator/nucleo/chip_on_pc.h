// The Nucleo's firmware on this PC: its registers are memory of the test's, which is asked for each access.
#ifndef LAKE_CHIP_ON_PC_H
#define LAKE_CHIP_ON_PC_H

#include <stdint.h>

typedef struct {
  void* chip;
  void* (*at)(void* chip, uint32_t address);
  void (*sleep)(void* chip);  // until an interrupt has been served
} chip_on_pc_t;
extern chip_on_pc_t chip_on_pc;

#define REGISTERS_AT(address) chip_on_pc.at(chip_on_pc.chip, address)

#endif
