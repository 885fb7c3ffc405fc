#include "pins.h"

#include "stm32f4.h"

// Port and bit, as a digit each: UM1724, Arduino connectors.
enum { A = 0x00, B = 0x10, C = 0x20 };
static const uint8_t kPlaces[] = {A + 3, A + 2, A + 10, B + 3, B + 5, B + 4, B + 10, A + 8, A + 9, C + 7,
                                  B + 6, A + 7, A + 6,  A + 5, A + 0, A + 1, A + 4,  B + 0, C + 1, C + 0};

static gpio_t* port_of(uint8_t pin) {
  const uint8_t port = kPlaces[pin] & 0xF0;
  return port == A ? GPIOA : port == B ? GPIOB : GPIOC;
}

static uint8_t bit_of(uint8_t pin) {
  return kPlaces[pin] & 0x0F;
}

static void set_field(reg_t* fields, uint8_t place, uint8_t width, uint32_t value) {
  const uint32_t mask = (BIT(width) - 1) << (place * width);
  *fields = (*fields & ~mask) | value << (place * width);
}

void pin_write(uint8_t pin, uint8_t is_high) {
  port_of(pin)->set_reset = BIT(bit_of(pin) + (is_high ? 0 : 16));
}

uint8_t pin_read(uint8_t pin) {
  return (port_of(pin)->input >> bit_of(pin)) & 1;
}

void pin_mode(uint8_t pin, uint8_t mode) {
  set_field(&port_of(pin)->mode, bit_of(pin), 2, mode);
}

void pin_pull_up(uint8_t pin) {
  set_field(&port_of(pin)->pull, bit_of(pin), 2, 1);
}

void pin_alternate(uint8_t pin, uint8_t function) {
  const uint8_t bit = bit_of(pin);
  set_field(&port_of(pin)->alternate[bit / 8], bit % 8, 4, function);
}

void pin_disconnect(uint8_t pin) {
  const uint32_t mode = (port_of(pin)->mode >> (2 * bit_of(pin))) & 3;
  if (mode == MODE_ALTERNATE) pin_mode(pin, MODE_OUTPUT);
}
