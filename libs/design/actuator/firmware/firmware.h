// The firmware as the Arduino IDE's setup() and loop(), or main(), call it.
#ifndef LAKE_FIRMWARE_H
#define LAKE_FIRMWARE_H

void firmware_begin(void);
void firmware_turn(void);  // over and over

#endif
