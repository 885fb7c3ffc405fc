// What waits to be sent and to be read, between the registers of a board's serial line and serial.h. A part of each
// board's serial.c, which alone includes it: so the compiler sees all that an interrupt does.
#ifndef LAKE_SERIAL_RINGS_H
#define LAKE_SERIAL_RINGS_H

#include "portable.h"
#include "serial.h"

#define TX_SIZE 128  // powers of two
#define RX_SIZE 128  // 11 ms of characters back to back; sending a row takes 8 ms

static volatile char tx[TX_SIZE];
static volatile uint8_t tx_head, tx_tail;
static volatile char rx[RX_SIZE];
static volatile uint8_t rx_head, rx_tail;

// Where the buffer is full the last character is lost as well, so that no line looks whole that is not.
static void keep(char c) {
  const uint8_t next = (rx_head + 1) & (RX_SIZE - 1);
  if (next == rx_tail) {
    rx[(rx_head - 1) & (RX_SIZE - 1)] = SERIAL_LOST;
    return;
  }
  rx[rx_head & (RX_SIZE - 1)] = c;
  rx_head = next;
}

static void receive(char c) {
  switch (serial_realtime(c)) {
    case REALTIME_DONE:
      return;
    case REALTIME_FORGET:
      rx_tail = rx_head;
      keep(SERIAL_FORGET);
      return;
    case REALTIME_NONE:
      keep(c);
  }
}

static uint8_t all_is_sent(void) {
  return tx_head == tx_tail;
}

static char next_to_send(void) {
  const char c = tx[tx_tail & (TX_SIZE - 1)];
  tx_tail = (tx_tail + 1) & (TX_SIZE - 1);
  return c;
}

int16_t serial_read(void) {
  int16_t c = -1;
  ATOMICALLY {
    if (rx_tail != rx_head) {
      c = (uint8_t)rx[rx_tail & (RX_SIZE - 1)];
      rx_tail = (rx_tail + 1) & (RX_SIZE - 1);
    }
  }
  return c;
}

uint8_t serial_has_room(void) {
  return (uint8_t)(tx_tail - tx_head - 1) % TX_SIZE >= SERIAL_LINE;
}

// 0 where there is no room.
static uint8_t queue(char c) {
  const uint8_t next = (tx_head + 1) & (TX_SIZE - 1);
  if (next == tx_tail) return 0;
  tx[tx_head & (TX_SIZE - 1)] = c;
  tx_head = next;
  return 1;
}

#endif
