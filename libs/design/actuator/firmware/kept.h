// A second copy of what nothing but its own module changes, bit by bit the inverse: a bit that flips in either is seen.
#ifndef LAKE_KEPT_H
#define LAKE_KEPT_H

#include <stdint.h>

// All of them are passed in the same order, once to make the copies and once to compare with them.
typedef enum { KEPT_COMPARE, KEPT_COPY } kept_t;
void kept_begin(void);

// Nonzero if it is as its copy says; KEPT_COPY makes the copy.
uint8_t kept_pass(const void* original, uint8_t bytes, kept_t what);

#endif
