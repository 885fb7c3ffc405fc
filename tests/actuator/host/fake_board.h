// Bridge, end stops and serial line of the firmware's portable part when it runs on a PC.
#pragma once

#include <cstdint>
#include <string>

struct FakeBoard {
  enum class Bridge { kOff, kBrake, kDrive };

  Bridge bridge = Bridge::kOff;
  int direction = 0;      // of IN1 and IN2
  int counts = 0;         // of ENA while it drives
  bool shorted = false;   // the inputs were turned while the bridge drove: this must never be
  std::uint8_t open = 0;  // end stops, bits as in end_stops.h
  std::uint16_t adc = 0;
  std::string said;  // over the serial line
  std::uint8_t remembered[256] = {};
  bool enable_is_held = false;
  std::uint32_t blocked = 0;  // how deep in blocks that no interrupt divides
  std::string received;       // to be read next
};

extern FakeBoard fake_board;
