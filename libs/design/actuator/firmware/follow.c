#include "follow.h"

#include "config.h"
#include "portable.h"

#if LAKE_FEEDBACK

#define PROPORTIONAL 8  // per s
#define INTEGRAL 12     // per s^2

// Against its direction a program's stretch is not driven: ahead by AHEAD_UM the actuator waits until the plan is there
// but for CLOSE_UM. At a planned rest it is put right from APART_UM on. Each stop costs a brake.
#define AHEAD_UM 400
#define APART_UM 300
#define CLOSE_UM 80

static int32_t summed_error;  // um ms
static int8_t correcting;     // at a planned rest, or waiting (0) within a stretch
static uint8_t is_waiting;

void follow_begin(void) {
  summed_error = 0;
  correcting = 0;
  is_waiting = 0;
}

static int32_t magnitude(int32_t value) {
  return value < 0 ? -value : value;
}

static int32_t least_um_s(int8_t direction) {
  return direction < 0 ? LAKE_RETRACT_LEAST_UM_S : LAKE_EXTEND_LEAST_UM_S;
}

static int32_t most_um_s(int8_t direction) {
  return direction < 0 ? LAKE_RETRACT_MOST_UM_S : LAKE_EXTEND_MOST_UM_S;
}

static int32_t within_table(int8_t direction, int32_t speed_um_s) {
  const int32_t along = direction * speed_um_s;
  if (along < least_um_s(direction)) return direction * least_um_s(direction);
  if (along > most_um_s(direction)) return direction * most_um_s(direction);
  return speed_um_s;
}

// What holds it back here has nothing to do with what the program's stretches have learnt.
static int32_t at_rest(int32_t error_um) {
  static int32_t summed_at_rest;
  const int8_t direction = error_um < 0 ? -1 : 1;
  if (magnitude(error_um) > APART_UM && correcting != direction) {
    correcting = direction;
    summed_at_rest = 0;
  }
  if (correcting != direction || magnitude(error_um) < CLOSE_UM) correcting = 0;
  if (!correcting) return 0;
  summed_at_rest += error_um;
  return within_table(direction, PROPORTIONAL * error_um + summed_at_rest / 1024 * INTEGRAL);
}

int32_t follow_speed(int32_t planned_um, int32_t planned_um_s, int32_t measured_um) {
  const int32_t error_um = planned_um - measured_um;
  if (planned_um_s == 0) return at_rest(error_um);
  const int8_t direction = planned_um_s < 0 ? -1 : 1;
  const int32_t behind_um = direction * error_um;
  correcting = 0;
  if (behind_um < -AHEAD_UM) is_waiting = 1;
  if (behind_um > -CLOSE_UM) is_waiting = 0;
  const int32_t wanted = planned_um_s + PROPORTIONAL * error_um + summed_error / 1024 * INTEGRAL;
  const int32_t speed = within_table(direction, wanted);
  // The sum stands still while it could only drive the speed farther out of its range.
  if (speed == wanted || (wanted > speed) == (error_um < 0)) summed_error += error_um;
  return is_waiting ? 0 : speed;
}

uint16_t follow_counts(int32_t speed_um_s) {
  const uint8_t retracts = speed_um_s < 0;
  const uint32_t speed = magnitude(speed_um_s);
  const uint32_t* row = lake_speed_um_s[retracts];
  const uint16_t most = retracts ? LAKE_RETRACT_MOST_COUNTS : LAKE_EXTEND_MOST_COUNTS;
  uint8_t low = retracts ? LAKE_RETRACT_FIRST_NODE : LAKE_EXTEND_FIRST_NODE;
  uint8_t high = LAKE_SPEED_INTERVALS;
  if (speed == 0) return 0;
  while (high - low > 1) {
    const uint8_t middle = (low + high) / 2;
    if (pgm_read_dword(&row[middle]) < speed)
      low = middle;
    else
      high = middle;
  }
  const uint32_t below = pgm_read_dword(&row[low]);
  const uint32_t step = pgm_read_dword(&row[high]) - below;
  uint32_t counts = (uint32_t)low * LAKE_PWM_PERIOD / LAKE_SPEED_INTERVALS;
  if (speed > below && step > 0) counts += (speed - below) * (LAKE_PWM_PERIOD / LAKE_SPEED_INTERVALS) / step;
  return counts > most ? most : (uint16_t)counts;
}

// Watched over stretches of WATCH_NM of driven way.
#define WATCH_NM 3000000L
#define LEAST_PART 12     // of the driven way, one in so many must be seen
#define WRONG_WAY_UM 800  // more than noise, play and a load's give
#define SUPPLY_UM_S 2000  // what a high supply and a load that helps add near the dead band
#define TOO_FAR_UM 3000   // beyond that and twice the driven way
#define UNDRIVEN_UM 1000  // with the bridge off
#define RUN_DOWN_MS 250   // after which the motor must be at rest

static uint16_t rest_ms;

void follow_watch_begin(void) {
  rest_ms = 0;
}

uint8_t follow_watch(int32_t driven_um_s, int32_t measured_um) {
  static int8_t last_direction;
  static int32_t from_um;
  static int32_t driven_nm, allowed_nm;
  const int8_t direction = (driven_um_s > 0) - (driven_um_s < 0);
  if (direction == 0) {
    if (rest_ms < RUN_DOWN_MS) {
      ++rest_ms;
      from_um = measured_um;
    }
    last_direction = 0;
    return magnitude(measured_um - from_um) > UNDRIVEN_UM ? FOLLOW_RUNAWAY : FOLLOW_FINE;
  }
  rest_ms = 0;
  if (direction != last_direction) {
    last_direction = direction;
    from_um = measured_um;
    driven_nm = allowed_nm = 0;
  }
  driven_nm += magnitude(driven_um_s);
  allowed_nm += 2 * magnitude(driven_um_s) + SUPPLY_UM_S;
  const int32_t seen_um = direction * (measured_um - from_um);
  if (seen_um < -WRONG_WAY_UM) return FOLLOW_WRONG_WAY;
  if (seen_um > allowed_nm / 1024 + TOO_FAR_UM) return FOLLOW_RUNAWAY;
  if (driven_nm < WATCH_NM) return FOLLOW_FINE;
  if (seen_um * LEAST_PART < driven_nm / 1024) return FOLLOW_NO_MOTION;
  from_um = measured_um;
  driven_nm = allowed_nm = 0;
  return FOLLOW_FINE;
}

#else

typedef int follow_is_empty;  // without feedback

#endif
