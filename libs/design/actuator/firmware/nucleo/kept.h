// Numbers that outlive resets and lost power, in two sectors of the flash, since the chip has no EEPROM. Each is added
// behind the last; what stands there is tidied into the other sector before the firmware runs.
#ifndef LAKE_KEPT_H
#define LAKE_KEPT_H

#include <stdint.h>

// Before the watchdog: at the very first start, and after some 500 that were kept, it takes up to 2.1 s.
void kept_init(void);

uint8_t kept_read(uint8_t place);  // 0 where none was ever kept

// Up to 0.1 ms, in which the chip stands. After KEPT_MOST of them in one session nothing is kept any more.
#define KEPT_MOST 8000u
void kept_write(uint8_t place, uint8_t number);

#endif
