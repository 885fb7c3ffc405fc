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

// Of what nothing but its own module changes, in words: a bit that flips changes it. For types of an even size.
typedef uint16_t __attribute__((may_alias)) word_t;
static inline uint16_t sum_of(const void* words, uint8_t bytes) {
  const word_t* w = (const word_t*)words;
  uint16_t sum = 0x5AA5;
  for (uint8_t left = bytes / 2; left > 0; --left) sum ^= *w++;
  return sum;
}

#endif
