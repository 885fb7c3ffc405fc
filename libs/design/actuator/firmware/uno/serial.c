#include "serial.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <util/atomic.h>

#ifndef F_CPU
#define F_CPU 16000000UL
#endif
#define BAUD 115200
#define BAUD_TOL 3  // 16 MHz gives 117647, 2.1 % too fast: within what the receiver of a frame of 10 bits tolerates
#include <util/setbaud.h>

#define TX_SIZE 128  // powers of two
#define RX_SIZE 128  // 11 ms of characters back to back; saying a row takes 7 ms

static volatile char tx[TX_SIZE];
static volatile uint8_t tx_head, tx_tail;
static volatile char rx[RX_SIZE];
static volatile uint8_t rx_head, rx_tail;

void serial_init(void) {
#if USE_2X
  UCSR0A = _BV(U2X0);
#else
  UCSR0A = 0;
#endif
  UBRR0 = UBRR_VALUE;  // after U2X0: simavr works the speed out when this is written
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0);
}

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

ISR(USART_RX_vect) {
  const uint8_t is_broken = UCSR0A & (_BV(FE0) | _BV(DOR0));
  const char c = UDR0;
  if (is_broken) keep(SERIAL_LOST);
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

ISR(USART_UDRE_vect) {
  if (tx_head == tx_tail) {
    UCSR0B &= ~_BV(UDRIE0);
  } else {
    UDR0 = tx[tx_tail & (TX_SIZE - 1)];
    tx_tail = (tx_tail + 1) & (TX_SIZE - 1);
  }
}

int16_t serial_read(void) {
  int16_t c = -1;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    if (rx_tail != rx_head) {
      c = (uint8_t)rx[rx_tail & (RX_SIZE - 1)];
      rx_tail = (rx_tail + 1) & (RX_SIZE - 1);
    }
  }
  return c;
}

void serial_write(char c) {
  const uint8_t next = (tx_head + 1) & (TX_SIZE - 1);
  while (next == tx_tail) sleep_mode();
  tx[tx_head & (TX_SIZE - 1)] = c;
  tx_head = next;
  UCSR0B |= _BV(UDRIE0);
}
