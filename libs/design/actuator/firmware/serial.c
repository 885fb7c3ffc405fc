#include "serial.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>

#ifndef F_CPU
#define F_CPU 16000000UL
#endif
#define BAUD 115200
#define BAUD_TOL 3  // 16 MHz gives 117647, 2.1 % too fast: within what the receiver of a frame of 10 bits tolerates
#include <util/setbaud.h>

#define TX_SIZE 128  // a power of two

static volatile char tx[TX_SIZE];
static volatile uint8_t tx_head, tx_tail;

static volatile char rx[SERIAL_LINE_MAX];
static volatile uint8_t rx_length, rx_whole, rx_overflow;
static char line[SERIAL_LINE_MAX + 1];
static uint8_t (*is_realtime)(char);

void serial_init(uint8_t (*realtime)(char)) {
  is_realtime = realtime;
  UBRR0 = UBRR_VALUE;
#if USE_2X
  UCSR0A = _BV(U2X0);
#else
  UCSR0A = 0;
#endif
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0);
}

// Characters that arrive while a whole line waits are dropped: commands are sent one at a time.
ISR(USART_RX_vect) {
  const char c = UDR0;
  if (is_realtime(c) || rx_whole) return;
  if (c == '\n' || c == '\r') {
    rx_whole = rx_length > 0 || rx_overflow;
  } else if (rx_length < SERIAL_LINE_MAX - 1) {
    rx[rx_length++] = c;
  } else {
    rx_overflow = 1;
  }
}

ISR(USART_UDRE_vect) {
  if (tx_head == tx_tail) {
    UCSR0B &= ~_BV(UDRIE0);
  } else {
    UDR0 = tx[tx_tail];
    tx_tail = (tx_tail + 1) & (TX_SIZE - 1);
  }
}

const char* serial_line(void) {
  if (!rx_whole) return 0;
  uint8_t length = rx_length;
  for (uint8_t i = 0; i < length; ++i) line[i] = rx[i];
  if (rx_overflow) line[length++] = '\n';
  line[length] = 0;
  rx_length = 0;
  rx_overflow = 0;
  rx_whole = 0;
  return line;
}

void serial_char(char c) {
  const uint8_t next = (tx_head + 1) & (TX_SIZE - 1);
  while (next == tx_tail) sleep_mode();
  tx[tx_head] = c;
  tx_head = next;
  UCSR0B |= _BV(UDRIE0);
}

void serial_text(const char* flash_text) {
  for (char c; (c = pgm_read_byte(flash_text)); ++flash_text) serial_char(c);
}
