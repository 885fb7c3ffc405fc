// The UNO's numbers of pins as ports and bits of the ATmega328P: 0 to 7 port D, 8 to 13 port B, 14 to 19 (A0 to A5)
// port C. With constants the compiler makes single instructions of these.
#ifndef LAKE_PINS_H
#define LAKE_PINS_H

#include <avr/io.h>

#define PIN_BIT(pin) ((uint8_t)(1 << ((pin) < 8 ? (pin) : (pin) < 14 ? (pin)-8 : (pin)-14)))

#define PIN_WRITE(pin, on)     \
  do {                         \
    if ((pin) < 8)             \
      PIN_SET(PORTD, pin, on); \
    else if ((pin) < 14)       \
      PIN_SET(PORTB, pin, on); \
    else                       \
      PIN_SET(PORTC, pin, on); \
  } while (0)
#define PIN_OUTPUT(pin, on)   \
  do {                        \
    if ((pin) < 8)            \
      PIN_SET(DDRD, pin, on); \
    else if ((pin) < 14)      \
      PIN_SET(DDRB, pin, on); \
    else                      \
      PIN_SET(DDRC, pin, on); \
  } while (0)
#define PIN_SET(port, pin, on)        \
  do {                                \
    if (on)                           \
      port |= PIN_BIT(pin);           \
    else                              \
      port &= (uint8_t)~PIN_BIT(pin); \
  } while (0)
#define PIN_IS_SET(pin) (((pin) < 8 ? PORTD : (pin) < 14 ? PORTB : PORTC) & PIN_BIT(pin))  // as an output
#define PIN_READ(pin) (((pin) < 8 ? PIND : (pin) < 14 ? PINB : PINC) & PIN_BIT(pin))

#endif
