#include "divide.h"

// 65536 = 65 * 1000 + 536: each turn takes 16 bits into the quotient, until the rest has no more than 16.
static uint32_t unsigned_thousandth(uint32_t number) {
  uint32_t quotient = 0;
  while (number > 0xFFFF) {
    const uint16_t high = (uint16_t)(number >> 16);
    quotient += high * (uint32_t)65;
    number = high * (uint32_t)536 + (uint16_t)number;
  }
  // number / 8 / 125: 33555 is 2^22 / 125 and so little more that 13 bits divide exactly.
  return quotient + (uint16_t)((((uint16_t)number >> 3) * (uint32_t)33555) >> 22);
}

int32_t thousandth(int32_t number) {
  const uint32_t magnitude = number < 0 ? 0 - (uint32_t)number : (uint32_t)number;
  const int32_t quotient = (int32_t)unsigned_thousandth(magnitude);
  return number < 0 ? -quotient : quotient;
}
