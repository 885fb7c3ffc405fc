#include "kept.h"

#include "stm32f4.h"

// A sector begins with a mark, written last, so that one that was not finished counts as empty. Each further half word
// has a place and its number; the last one of a place counts. 0xFFFF is erased flash: there is no place 255.
#define MARK 0x4B54
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

static void erase(uint8_t which) {
  work(FLASH_CR_SER | FLASH_CR_SECTOR(FIRST_SECTOR + which));
  FLASH->cr |= FLASH_CR_STRT;
  rest();
}

// Below `end`, the newest first.
static uint8_t read_from(uint8_t which, uint16_t end, uint8_t place) {
  const half_t* halves = sector(which);
  while (--end > 0)
    if (halves[end] >> 8 == place) return (uint8_t)halves[end];
  return 0;
}

static void tidy_into(uint8_t other) {
  uint16_t next = 1;
  erase(other);
  for (uint8_t place = 0; place < 255; ++place) {
    const uint8_t number = read_from(active, used, place);
    if (number > 0) write_half(sector(other) + next++, (uint16_t)(place << 8 | number));
  }
  write_half(sector(other), MARK);
  erase(active);
  active = other;
  used = next;
}

void kept_init(void) {
  active = sector(0)[0] != MARK && sector(1)[0] == MARK;
  if (sector(active)[0] != MARK) {
    erase(active);
    write_half(sector(active), MARK);
  }
  used = 1;
  while (used < KEPT_MOST && sector(active)[used] != ERASED) ++used;
  // Both have the mark where power was lost between the two last steps of tidying: they hold the same.
  if (sector(!active)[0] == MARK) erase(!active);
  if (used > TIDY_FROM) tidy_into(!active);
}

uint8_t kept_read(uint8_t place) {
  return read_from(active, used, place);
}

void kept_write(uint8_t place, uint8_t number) {
  if (used >= KEPT_MOST || kept_read(place) == number) return;
  write_half(sector(active) + used++, (uint16_t)(place << 8 | number));
}
