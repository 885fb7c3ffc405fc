#include "kept.h"

#include "stm32f4.h"

// A sector begins with a mark, written last, so that one that was not finished counts as empty, and taken away, by
// zeros, when another has it: only a sector without a mark is erased, so one that lost its power in that never counts.
// Each further half word has a place and its number; the last one of a place counts. 0xFFFF is erased flash: there is
// no place 255.
#define MARK 0x4B54
#define NO_MARK 0
#define ERASED 0xFFFF
#define TIDY_FROM 500u
#define FIRST_SECTOR 6

typedef volatile uint16_t half_t;

static uint8_t active;  // of the two sectors
static uint16_t used;   // its half words, with the mark

static half_t* sector(uint8_t which) {
  return which ? (half_t*)REGISTERS_AT(0x08060000) : (half_t*)REGISTERS_AT(0x08040000);
}

static void work(uint32_t what) {
  FLASH->keyr = FLASH_KEY1;
  FLASH->keyr = FLASH_KEY2;
  FLASH->cr = what;
}

static void rest(void) {
  while (FLASH->sr & FLASH_SR_BSY) {
  }
  FLASH->cr = FLASH_CR_LOCK;
}

static void write_half(half_t* where, uint16_t what) {
  work(FLASH_CR_PG | FLASH_CR_HALFWORDS);
  *where = what;
  rest();
}

static uint8_t is_marked(uint8_t which) {
  return sector(which)[0] == MARK;
}

// By whole words, which a Nucleo's 3.3 V allow: 2 s at most, where bytes take 4.
static void erase(uint8_t which) {
  work(FLASH_CR_SER | FLASH_CR_WORDS | FLASH_CR_SECTOR(FIRST_SECTOR + which));
  FLASH->cr |= FLASH_CR_STRT;
  rest();
}

static void use(uint8_t which) {
  active = which;
  used = 1;
  while (used < KEPT_MOST && sector(active)[used] != ERASED) ++used;
}

static void tidy_into(uint8_t other) {
  const half_t* halves = sector(active);
  uint8_t newest[256] = {0};
  uint16_t next = 1;
  for (uint16_t i = 1; i < used; ++i) newest[halves[i] >> 8] = (uint8_t)halves[i];
  erase(other);
  for (uint8_t place = 0; place < 255; ++place)
    if (newest[place] > 0) write_half(sector(other) + next++, (uint16_t)(place << 8 | newest[place]));
  write_half(sector(other), MARK);
  write_half(sector(active), NO_MARK);
  active = other;
  used = next;
}

void kept_init(void) {
  if (!is_marked(0) && !is_marked(1)) {
    erase(0);
    write_half(sector(0), MARK);
  }
  use(!is_marked(0));
  // Both have the mark where power was lost between the two last steps of tidying: they hold the same.
  if (is_marked(!active)) write_half(sector(!active), NO_MARK);
  if (used > TIDY_FROM) tidy_into(!active);
}

// The newest first.
uint8_t kept_read(uint8_t place) {
  const half_t* halves = sector(active);
  for (uint16_t i = used; --i > 0;)
    if (halves[i] >> 8 == place) return (uint8_t)halves[i];
  return 0;
}

void kept_write(uint8_t place, uint8_t number) {
  if (used >= KEPT_MOST || kept_read(place) == number) return;
  write_half(sector(active) + used++, (uint16_t)(place << 8 | number));
}
