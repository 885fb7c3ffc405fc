// What the analogue inputs tell, of those that stroke_table.h says are wired: the motor's supply, its current, the
// stroke by the actuator's potentiometer; filtered once per ms, and whether they can be true.
#ifndef LAKE_ANALOG_H
#define LAKE_ANALOG_H

#include <stdint.h>

enum {
  ANALOG_NO_SUPPLY = 1,      // outside its limits: off, sagging, or the sense wire
  ANALOG_NO_WIPER = 2,       // the potentiometer reads what it cannot: lost, shorted, or it jumps
  ANALOG_OVERCURRENT = 4,    // a short, at once
  ANALOG_STALL_CURRENT = 8,  // less, but for long
  ANALOG_NO_CURRENT = 16     // none while the bridge drives: motor, supply or sense wire
};

void analog_init(void);

// Once per ms; `counts`: what the bridge drives, 0 if it does not.
void analog_tick(uint16_t counts);

// Bits of what is wrong now.
uint8_t analog_faults(void);

int32_t analog_stroke_um(void);   // 0 without a potentiometer
int16_t analog_current_ma(void);  // 0 without a sensor

#endif
