// What cannot wait for the main loop: the motor is off within the ms at an end stop that it is driven towards, once the
// button is let go, at a short, and once the main loop or the converter is late. It looks at the pins, not at what the
// controller thinks; what it came from the controller finds out by itself.
#ifndef LAKE_GUARD_H
#define LAKE_GUARD_H

void guard_interrupt(void);  // once per ms, inside the timer's interrupt

#endif
