#include "chip.h"
#include "pins.h"
#include "serial.rings.h"
#include "stm32f4.h"

// USART2, which the ST-LINK makes a serial port of the computer's: D0 receives, D1 sends, alternate function 7.
#define SERIAL_FUNCTION 7
#define PIN_RECEIVES 0
#define PIN_SENDS 1
#define DIVIDER 139  // 16 MHz / 115200, 0.08 % slow

void serial_init(void) {
  pin_alternate(PIN_RECEIVES, SERIAL_FUNCTION);
  pin_alternate(PIN_SENDS, SERIAL_FUNCTION);
  pin_mode(PIN_RECEIVES, MODE_ALTERNATE);
  pin_mode(PIN_SENDS, MODE_ALTERNATE);
  pin_pull_up(PIN_RECEIVES);
  USART2->brr = DIVIDER;
  USART2->cr1 = USART_CR1_UE | USART_CR1_RE | USART_CR1_TE | USART_CR1_RXNEIE;
}

static void send(void) {
  if (all_is_sent()) {
    USART2->cr1 &= ~USART_CR1_TXEIE;
  } else {
    USART2->dr = (uint8_t)next_to_send();
  }
}

void USART2_IRQHandler(void) {
  const uint32_t status = USART2->sr;
  if (status & (USART_SR_RXNE | USART_SR_ORE)) {
    const char c = (char)USART2->dr;  // after the status: that clears its errors
    if (status & (USART_SR_FE | USART_SR_NE | USART_SR_ORE)) keep(SERIAL_LOST);
    receive(c);
  }
  if ((status & USART_SR_TXE) && (USART2->cr1 & USART_CR1_TXEIE)) send();
}

void serial_write(char c) {
  while (!queue(c)) chip_sleep();
  ATOMICALLY {
    USART2->cr1 |= USART_CR1_TXEIE;
  }
}
