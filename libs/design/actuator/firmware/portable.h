// What the portable part of the firmware needs of its compiler: tables and texts in flash, and blocks that no interrupt
// divides. With any other compiler than avr-gcc flash is memory, and the board says how interrupts are blocked: so the
// same sources are tested on a PC.
#ifndef LAKE_PORTABLE_H
#define LAKE_PORTABLE_H

#include <stdint.h>
#include <string.h>

#ifdef __AVR__

#include <avr/pgmspace.h>
#include <util/atomic.h>
#define ATOMICALLY ATOMIC_BLOCK(ATOMIC_RESTORESTATE)

#else

uint32_t portable_block(void);         // no interrupt from here on; returns what was
void portable_restore(uint32_t what);  // as it was
#define ATOMICALLY for (uint32_t blocked_ = portable_block(), once_ = 1; once_; once_ = 0, portable_restore(blocked_))

#define PROGMEM
#define PSTR(text) (text)
#define memcpy_P memcpy
#define strcmp_P strcmp
#define strncmp_P strncmp
#define pgm_read_byte(address) (*(address))
#define pgm_read_word(address) (*(address))
#define pgm_read_dword(address) (*(address))

#endif

#endif
