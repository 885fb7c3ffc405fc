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
}
void bridge_brake(void) {
  fake_board.bridge = FakeBoard::Bridge::kBrake;
  fake_board.direction = 0;
}
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

uint8_t board_remembered(void) {
  return fake_board.remembered;
}
void board_remember(uint8_t number) {
  fake_board.remembered = number;
}
