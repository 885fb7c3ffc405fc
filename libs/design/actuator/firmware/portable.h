// What the portable part of the firmware needs of its compiler: tables and texts in flash, and blocks that no interrupt
// divides. With any other compiler than avr-gcc flash is memory and there are no interrupts: so the same sources are
// tested on a PC.
#ifndef LAKE_PORTABLE_H
#define LAKE_PORTABLE_H

#include <stdint.h>
#include <string.h>

#ifdef __AVR__

#include <avr/pgmspace.h>
#include <util/atomic.h>
#define ATOMICALLY ATOMIC_BLOCK(ATOMIC_RESTORESTATE)

#else

#define PROGMEM
#define PSTR(text) (text)
#define ATOMICALLY
#define memcpy_P memcpy
#define strcmp_P strcmp
#define strncmp_P strncmp
#define pgm_read_byte(address) (*(address))
#define pgm_read_dword(address) (*(address))

#endif

#endif
