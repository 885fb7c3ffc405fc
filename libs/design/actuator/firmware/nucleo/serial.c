#include "serial.h"

#include "chip.h"
#include "pins.h"
#include "portable.h"
#include "stm32f4.h"

// USART2, which the ST-LINK makes a serial port of the computer's: D0 receives, D1 sends, alternate function 7.
#define SERIAL_FUNCTION 7
#define PIN_RECEIVES 0
#define PIN_SENDS 1
#define DIVIDER 139  // 16 MHz / 115200, 0.08 % slow

#define TX_SIZE 128  // powers of two
#define RX_SIZE 128

static volatile char tx[TX_SIZE];
static volatile uint8_t tx_head, tx_tail;
static volatile char rx[RX_SIZE];
static volatile uint8_t rx_head, rx_tail;

void serial_init(void) {
  pin_alternate(PIN_RECEIVES, SERIAL_FUNCTION);
  pin_alternate(PIN_SENDS, SERIAL_FUNCTION);
  pin_mode(PIN_RECEIVES, MODE_ALTERNATE);
  pin_mode(PIN_SENDS, MODE_ALTERNATE);
  pin_pull_up(PIN_RECEIVES);
  USART2->brr = DIVIDER;
  USART2->cr1 = USART_CR1_UE | USART_CR1_RE | USART_CR1_TE | USART_CR1_RXNEIE;
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

static void send(void) {
  if (tx_head == tx_tail) {
    USART2->cr1 &= ~USART_CR1_TXEIE;
  } else {
    USART2->dr = (uint8_t)tx[tx_tail & (TX_SIZE - 1)];
    tx_tail = (tx_tail + 1) & (TX_SIZE - 1);
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

void serial_write(char c) {
  const uint8_t next = (tx_head + 1) & (TX_SIZE - 1);
  while (next == tx_tail) chip_sleep();
  tx[tx_head & (TX_SIZE - 1)] = c;
  tx_head = next;
  ATOMICALLY {
    USART2->cr1 |= USART_CR1_TXEIE;
  }
}
