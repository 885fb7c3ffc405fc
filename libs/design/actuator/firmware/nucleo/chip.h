// The chip of a Nucleo-64 (STM32F401RE, F411RE, F446RE) beneath its peripherals: clock, waits, interrupts, sleep.
#ifndef LAKE_CHIP_H
#define LAKE_CHIP_H

#include <stdint.h>

#define CHIP_CLOCKS_PER_US 16

// 16 MHz from the crystal of the ST-LINK, so that a PWM's count and a ms are those of an UNO, and clocks for what the
// firmware uses. Before anything else. Without that crystal nothing starts; where it is lost later an NMI comes.
void chip_init(void);

void chip_wait_us(uint8_t us);
void chip_enable(uint8_t interrupt, uint8_t priority);  // 0 is served first, 15 last

// Instructions of the core: cortex.c.
void chip_sleep(void);  // until an interrupt
void chip_allow_interrupts(void);

#endif
