#include "fake_board.h"

#include "board.h"
#include "bridge.h"
#include "serial.h"

FakeBoard fake_board;

void bridge_init(void) {
  fake_board.bridge = FakeBoard::Bridge::kOff;
  fake_board.direction = 0;
}
void bridge_off(void) {
  fake_board.bridge = FakeBoard::Bridge::kOff;
  fake_board.direction = 0;
}
void bridge_brake(void) {
  fake_board.bridge = FakeBoard::Bridge::kBrake;
}
uint8_t bridge_enable_is_free(void) {
  return !fake_board.enable_is_held;
}
uint8_t bridge_outputs_are_low(void) {
  return 1;
}
uint8_t bridge_outputs_contradict(void) {
  return 0;
}

uint32_t portable_block(void) {
  return fake_board.blocked++;
}
void portable_restore(uint32_t what) {
  fake_board.blocked = what;
}

void board_close_relay(uint8_t) {}

void bridge_direct(int8_t direction) {
  fake_board.shorted = fake_board.shorted || fake_board.bridge != FakeBoard::Bridge::kOff;
  fake_board.direction = direction;
}
void bridge_drive(uint16_t counts) {
  fake_board.bridge = FakeBoard::Bridge::kDrive;
  fake_board.counts = counts;
}

uint8_t board_end_stops(void) {
  return fake_board.open;
}
uint16_t board_analog(uint8_t) {
  return static_cast<uint16_t>(4 * fake_board.adc);
}

int16_t serial_read(void) {
  if (fake_board.received.empty()) return -1;
  const auto c = static_cast<unsigned char>(fake_board.received.front());
  fake_board.received.erase(0, 1);
  return c;
}
void serial_write(char c) {
  fake_board.said += c;
}

uint8_t board_is_late(void) {
  return 0;
}

uint8_t board_remembered(uint8_t place) {
  return fake_board.remembered[place];
}
void board_remember(uint8_t place, uint8_t number) {
  fake_board.remembered[place] = number;
}
