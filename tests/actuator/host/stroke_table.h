// Stroke program for the UNO. For the tests of the portable part.
#ifndef LAKE_STROKE_TABLE_H
#define LAKE_STROKE_TABLE_H

#include "portable.h"

#define LAKE_PWM_PERIOD 4000  // counts: 4 kHz at 16 MHz
#define LAKE_DEAD_TIME_MS 100  // brake before anything else
#define LAKE_COMMAND_TIMEOUT_MS 2000  // 0: none
#define LAKE_SEGMENT_COUNT 6
#define LAKE_DRIFT_START_UM 101  // the bound on the drift: at first, …
#define LAKE_DRIFT_PER_1024 103  // … per 1024 of the way, …
#define LAKE_LAG_MS 50  // … and per change of speed
#define LAKE_DRIFT_ACCEPTED 0
#define LAKE_DRIFT_LIMITED 1  // 0: accepted, or an extend end stop comes first
#define LAKE_SPEED_INTERVALS 16
#define LAKE_LOWER_LIMIT_UM 242498L
#define LAKE_UPPER_LIMIT_UM 374021L
#define LAKE_START_UM 300000L
#define LAKE_UPPER_END_UM 374521L  // of the linkage: what the drift must not reach
#define LAKE_STOP_TRAVEL_UM 2000L  // within which an end stop releases
#define LAKE_HOME_UM 298000L  // at the retract end stop
#define LAKE_HOME_COUNTS 2256
#define LAKE_HOME_SPEED_UM_S 5000L
#define LAKE_HOME_TIMEOUT_MS 24956L
#define LAKE_POSITION_COUNTS 2582  // from the end stop to the start
#define LAKE_POSITION_SPEED_UM_S 5000L
#define LAKE_POSITION_MS 400L
#define LAKE_BACK_OFF_MS 400L  // from the end stop, to see it release
#define LAKE_TOUCH_TIMEOUT_MS 1800L

typedef struct {
  uint32_t end_ms;         // since the program's start
  int32_t velocity_um_s;   // positive extends
  uint16_t counts;         // PWM
} lake_segment;

static const lake_segment lake_segments[LAKE_SEGMENT_COUNT] PROGMEM = {
    {500, 5000, 2582},
    {1000, 2000, 1673},
    {1100, 0, 0},
    {1600, -4000, 1978},
    {1900, 0, 0},
    {2100, 3000, 1976},
};

// um/s at equal steps of duty from 0 to 1: extending, retracting.
static const uint32_t lake_speed_um_s[2][LAKE_SPEED_INTERVALS + 1] PROGMEM = {
    {0, 0, 0, 0, 0, 605, 1430, 2255, 3080, 3905, 4730, 5555, 6380, 7205, 8030, 8855, 9680},
    {0, 0, 0, 0, 480, 1380, 2280, 3180, 4080, 4980, 5880, 6780, 7680, 8580, 9480, 10380, 11280}};

#endif
