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

const char* serial_line(void) {
  static std::string line;
  if (fake_board.line.empty()) return nullptr;
  line = fake_board.line;
  fake_board.line.clear();
  return line.c_str();
}
void serial_text(const char* flash_text) {
  fake_board.said += flash_text;
}
void serial_char(char c) {
  fake_board.said += c;
}
uint8_t board_is_late(void) {
  return 0;
}
