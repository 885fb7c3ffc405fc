// Stroke program for the UNO. For the tests of the portable part.
// CANNOT KNOW: The stroke is planned, not measured: a stall, a load, a slow or a reversed motor are not seen.
// CANNOT KNOW: Without an extend end stop nothing ends a motion the wrong way.
// CANNOT KNOW: It does not see the emergency stop: released, a program that is under way goes on by itself.
// CANNOT KNOW: It does not see the supply's voltage: 10 % less is 10 % and more of stroke.
// CANNOT KNOW: It does not feel a force: only the fuse limits it.
// CANNOT KNOW: The bridge's outputs are not read back: a stop coasts, without a brake.
// CANNOT KNOW: There is no second way to switch the motor off: a shorted transistor is reported, not stopped.
#ifndef LAKE_STROKE_TABLE_H
#define LAKE_STROKE_TABLE_H

#include "portable.h"

#define LAKE_PWM_PERIOD 4000  // counts: 4 kHz at 16 MHz
#define LAKE_DEAD_TIME_MS 100  // a stop before anything else
#define LAKE_COMMAND_TIMEOUT_MS 2000  // 0: none
#define LAKE_SEGMENT_COUNT 6
#define LAKE_PIN_ENA 9
#define LAKE_PIN_IN1 7
#define LAKE_PIN_IN2 8
#define LAKE_PIN_RETRACT 2
#define LAKE_PIN_EXTEND 3
#define LAKE_PIN_OUT1 17
#define LAKE_PIN_OUT2 18
#define LAKE_BRIDGE_SENSE 0
#define LAKE_RELAY 0
#define LAKE_BUTTON 0
#define LAKE_SUPPLY_SENSE 0
#define LAKE_SUPPLY_LEAST 0
#define LAKE_SUPPLY_MOST 0
#define LAKE_SUPPLY_NOMINAL 0
#define LAKE_SUPPLY_NEAR_LEAST 0  // in open loop
#define LAKE_SUPPLY_NEAR_MOST 0
#define LAKE_CURRENT_SENSE 0
#define LAKE_CURRENT_ZERO 2046
#define LAKE_CURRENT_UA_PER_COUNT 6605L
#define LAKE_CURRENT_MOST_MA 3000
#define LAKE_CURRENT_STALL_MA 2000
#define LAKE_CURRENT_LEAST_MA 100
#define LAKE_FEEDBACK 0
#define LAKE_DRIFT_START_UM 101  // the bound on the drift: at first, …
#define LAKE_DRIFT_PER_1024 103  // … per 1024 of the way, …
#define LAKE_LAG_MS 50  // … and per change of speed
#define LAKE_DRIFT_ACCEPTED 0
#define LAKE_DRIFT_LIMITED 1  // 0: accepted, or an extend end stop comes first
#define LAKE_SPEED_INTERVALS 64
#define LAKE_LOWER_LIMIT_UM 242498L
#define LAKE_UPPER_LIMIT_UM 374021L
#define LAKE_START_UM 300000L
#define LAKE_UPPER_END_UM 374521L  // of the linkage: what the drift must not reach
#define LAKE_STOP_TRAVEL_UM 2000L  // within which an end stop releases
#define LAKE_CHECK_UM 300L  // … while it is not known which way the motor turns
#define LAKE_EXTEND_CREEP_COUNTS 1267  // then
#define LAKE_EXTEND_CREEP_UM_S 660L
#define LAKE_RETRACT_CREEP_COUNTS 1167
#define LAKE_RETRACT_CREEP_UM_S 1080L
#define LAKE_SPEED_LIMIT_UM_S 11280L
#define LAKE_HOME_GUARD_UM 296000L  // where homing has passed its end stop
#define LAKE_EXTEND_STOP_UM 0L  // 0: there is none
#define LAKE_EXTEND_LEAST_UM_S 440L  // that the duty table has
#define LAKE_EXTEND_MOST_UM_S 9680L
#define LAKE_RETRACT_LEAST_UM_S 720L
#define LAKE_RETRACT_MOST_UM_S 11280L
#define LAKE_HOME_KNEE "83.2"  // degrees
#define LAKE_PROGRAM "ce55d025781d"
#define LAKE_DESIGN "unknown"
#define LAKE_DUTY_TABLE "MODEL, not measured"
#define LAKE_HOME_UM 297000L  // at the retract end stop
#define LAKE_HOME_COUNTS 2256
#define LAKE_HOME_SPEED_UM_S 5000L
#define LAKE_HOME_TIMEOUT_MS 18055L
#define LAKE_POSITION_COUNTS 2582  // away from the end stop
#define LAKE_POSITION_SPEED_UM_S 5000L
#define LAKE_POSITION_MS 200L  // from where it has released on to the start, …
#define LAKE_RETURN_MS 0L  // … or back to it
#define LAKE_BACK_OFF_MS 400L  // from the end stop, to see it release
#define LAKE_TOUCH_TIMEOUT_MS 1800L
#define LAKE_EXTEND_FIRST_NODE 18  // of lake_speed_um_s: below it a duty may also stand still
#define LAKE_RETRACT_FIRST_NODE 14
#define LAKE_EXTEND_MOST_COUNTS 4000u  // the duty table ends there
#define LAKE_RETRACT_MOST_COUNTS 4000u

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

// The greatest speed, um/s, at equal steps of duty from 0 to 1: extending, retracting.
static const uint32_t lake_speed_um_s[2][LAKE_SPEED_INTERVALS + 1] PROGMEM = {
    {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 192, 399, 605, 811, 1018, 1224, 1430, 1636, 1843, 2049, 2255, 2461, 2668, 2874, 3080, 3286, 3493, 3699, 3905, 4111, 4318, 4524, 4730, 4936, 5143, 5349, 5555, 5761, 5968, 6174, 6380, 6586, 6793, 6999, 7205, 7411, 7618, 7824, 8030, 8236, 8442, 8649, 8855, 9061, 9267, 9474, 9680},
    {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 30, 255, 480, 705, 930, 1155, 1380, 1605, 1830, 2055, 2280, 2505, 2730, 2955, 3180, 3405, 3630, 3855, 4080, 4305, 4530, 4755, 4980, 5205, 5430, 5655, 5880, 6105, 6330, 6555, 6780, 7005, 7230, 7455, 7680, 7905, 8130, 8355, 8580, 8805, 9030, 9255, 9480, 9705, 9930, 10155, 10380, 10605, 10830, 11055, 11280}};

#endif
