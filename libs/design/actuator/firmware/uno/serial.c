#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

#include "serial.rings.h"

#ifndef F_CPU
#define F_CPU 16000000UL
#endif
#define BAUD 115200
#define BAUD_TOL 3  // 16 MHz gives 117647, 2.1 % too fast: within what the receiver of a frame of 10 bits tolerates
#include <util/setbaud.h>

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

ISR(USART_RX_vect) {
  const uint8_t is_broken = UCSR0A & (_BV(FE0) | _BV(DOR0));
  const char c = UDR0;
  if (is_broken) keep(SERIAL_LOST);
  receive(c);
}

ISR(USART_UDRE_vect) {
  if (all_is_sent()) {
    UCSR0B &= ~_BV(UDRIE0);
  } else {
    UDR0 = next_to_send();
  }
}

void serial_write(char c) {
  while (!queue(c)) sleep_mode();
  UCSR0B |= _BV(UDRIE0);
}
