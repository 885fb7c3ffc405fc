// What the portable part of the firmware sees and does on a PC.
#ifndef LAKE_HOST_BOARD_H
#define LAKE_HOST_BOARD_H

#include <stdint.h>

enum { HOST_OFF, HOST_BRAKE, HOST_DRIVE };

typedef struct {
  int bridge;
  int direction;  // of IN1 and IN2
  int counts;     // of ENA while it drives
  int shorted;    // the inputs were turned while the bridge drove: this must never be
  uint8_t open;   // end stops, bits as in board.h
  int enabled;    // counts of ENA, LAKE_PWM_PERIOD while it is high
  int in1, in2;
  int enable_is_held;            // by a jumper or a wire at 5 V
  int output_is_stuck;           // high, whatever the bridge is told
  int outputs_contradict;        // what the bridge was told in the last ms
  int in1_is_high, in2_is_high;  // by broken wires
  uint8_t relay;
  uint8_t is_late;        // the main loop
  uint32_t blocked;       // how deep in blocks that no interrupt divides
  uint16_t adc[3];        // sums of four readings: A0 potentiometer, A1 current, A2 supply
  uint8_t received[256];  // a ring
  uint8_t received_head, received_tail;
  uint8_t remembered[256];  // outlives a reset
  char said[1 << 16];       // over the serial line since it was last taken
  uint32_t said_length;
} host_board_t;

#ifdef __cplusplus
extern host_board_t host_board;  // where the firmware is compiled into the program
#endif

#endif
