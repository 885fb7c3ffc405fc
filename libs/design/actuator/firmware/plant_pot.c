#include "analog.h"
#include "config.h"
#include "divide.h"
#include "motor.h"
#include "plant.h"
#include "portable.h"

uint32_t plant_node_um_s(uint8_t retracts, uint8_t node) {
  return pgm_read_dword(&lake_speed_um_s[retracts][node]);
}

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

// A motor that has no more speed than it gives is waited for from there on. More than the readings' noise, less than
// what a program's error is to be.
#define LAGS_UM 300
static uint8_t is_limited, lags;

static void follow_begin(void) {
  summed_error = 0;
  correcting = 0;
  is_waiting = 0;
  is_limited = lags = 0;
}

static int32_t magnitude(int32_t value) {
  return value < 0 ? -value : value;
}

static int32_t least_um_s(int8_t direction) {
  return direction < 0 ? LAKE_RETRACT_LEAST_UM_S : LAKE_EXTEND_LEAST_UM_S;
}

static int32_t most_um_s(int8_t direction) {
  const int32_t most = direction < 0 ? LAKE_RETRACT_MOST_UM_S : LAKE_EXTEND_MOST_UM_S;
  return most > LAKE_SPEED_LIMIT_UM_S ? LAKE_SPEED_LIMIT_UM_S : most;
}

static int32_t within_table(int8_t direction, int32_t speed_um_s) {
  int32_t along = direction < 0 ? -speed_um_s : speed_um_s;
  if (along < least_um_s(direction)) along = least_um_s(direction);
  if (along > most_um_s(direction)) along = most_um_s(direction);
  return direction < 0 ? -along : along;
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
  return within_table(direction, PROPORTIONAL * error_um + (summed_at_rest >> 10) * INTEGRAL);
}

// Feed-forward of the plan's speed and PI on the error, within what the duty table has. 0 is rest.
static int32_t follow_speed(int32_t planned_um, int32_t planned_um_s, int32_t measured_um) {
  const int32_t error_um = planned_um - measured_um;
  lags = 0;
  if (planned_um_s == 0) return at_rest(error_um);
  const int8_t direction = planned_um_s < 0 ? -1 : 1;
  const int32_t behind_um = direction < 0 ? -error_um : error_um;
  correcting = 0;
  if (behind_um < -AHEAD_UM) is_waiting = 1;
  if (behind_um > -CLOSE_UM) is_waiting = 0;
  const int32_t wanted = planned_um_s + PROPORTIONAL * error_um + (summed_error >> 10) * INTEGRAL;
  const int32_t speed = within_table(direction, wanted);
  // The sum stands still while it could only drive the speed farther out of its range.
  const int8_t lacks = is_limited ? direction : (int8_t)((wanted > speed) - (wanted < speed));
  if (lacks == 0 || (lacks > 0) == (error_um < 0)) summed_error += error_um;
  lags = behind_um > LAGS_UM && lacks == direction;
  return is_waiting ? 0 : speed;
}

#if LAKE_SPEED_INTERVALS != 64 || 16 * LAKE_PWM_PERIOD > 0xFFFF
#error "sixty_fourths and its shifts are for 64 intervals and a period of at most 4095 counts"
#endif

// Of a whole that is more than the part: by steps, a fifth of the time of the compiler's division.
static uint8_t sixty_fourths(uint32_t part, uint32_t whole) {
  uint8_t quotient = 0;
  for (uint8_t bit = 32; bit > 0; bit >>= 1) {
    part <<= 1;
    if (part < whole) continue;
    part -= whole;
    quotient |= bit;
  }
  return quotient;
}

// The inverse of the duty table.
static uint16_t counts_of(int32_t speed_um_s) {
  const uint8_t retracts = speed_um_s < 0;
  const uint32_t speed = magnitude(speed_um_s);
  const uint16_t most = retracts ? LAKE_RETRACT_MOST_COUNTS : LAKE_EXTEND_MOST_COUNTS;
  uint8_t low = retracts ? LAKE_RETRACT_FIRST_NODE : LAKE_EXTEND_FIRST_NODE;
  uint8_t high = LAKE_SPEED_INTERVALS;
  if (speed == 0) return 0;
  while (high - low > 1) {
    const uint8_t middle = (low + high) / 2;
    if (plant_node_um_s(retracts, middle) < speed)
      low = middle;
    else
      high = middle;
  }
  const uint32_t below = plant_node_um_s(retracts, low);
  const uint32_t step = plant_node_um_s(retracts, high) - below;
  uint16_t parts = (uint16_t)(low * LAKE_SPEED_INTERVALS);  // of 2^12
  if (speed > below) parts += speed - below < step ? sixty_fourths(speed - below, step) : LAKE_SPEED_INTERVALS;
  const uint16_t counts = (uint16_t)(((uint32_t)parts * (16u * LAKE_PWM_PERIOD)) >> 16);
  return counts > most ? most : counts;
}

enum {
  FOLLOW_FINE,
  FOLLOW_PROVEN,  // it has moved the way it is driven
  FOLLOW_STILL,   // driven, and not seen to go on
  FOLLOW_NO_MOTION,
  FOLLOW_WRONG_WAY,
  FOLLOW_RUNAWAY
};

// Watched over stretches of WATCH_NM of driven way.
#define WATCH_NM 3000000L
#define LEAST_PART 12      // of the driven way, one in so many must be seen
#define STILL_NM 600000L   // of driven way, in which it must be seen to go on …
#define STILL_UM 150       // … by more than this
#define PROVEN_UM 500      // more than noise and play
#define WRONG_WAY_UM 800   // more than noise, play and a load's give
#define WRONG_SOON_UM 300  // likewise, if it lasts …
#define WRONG_SOON_MS 30   // … so long
#define SUPPLY_UM_S 2000L  // what a high supply and a load that helps add near the dead band
#define TOO_FAR_UM 3000    // beyond that and twice the driven way
#define UNDRIVEN_UM 1000   // with the bridge off
#define RUN_DOWN_MS 250    // after which the motor must be at rest

// What no drive by the duty table does within QUICK_MS, driven or not.
#define QUICK_PLACES 8
#define QUICK_EVERY_MS 8
#define QUICK_MS (QUICK_PLACES * QUICK_EVERY_MS)
#define QUICK_UM 400  // beyond twice the driven way and SUPPLY_UM_S
#define QUICK_TIMES 2

static struct {
  uint16_t rest_ms;
  int8_t direction;
  uint8_t wrong_ms;
  int32_t from_um, slow_from_um;
  int32_t driven_nm, allowed_nm;
  int32_t slow_driven;           // um/s << SLOW: as late as the slow stroke
  int32_t went_on_um, still_nm;  // where it was last seen to have gone on, what was driven since
  int32_t was_um[QUICK_PLACES];
  int32_t went_nm[QUICK_PLACES];  // signed, from each of them to the next
  int32_t all_nm;                 // of these
  uint8_t place, place_ms, filled, quick;
} w;

void plant_reset(void) {
  w.rest_ms = 0;
  w.filled = w.quick = 0;
  w.slow_driven = 0;
}

// Whether it has gone far beyond what was driven in the last QUICK_MS.
static uint8_t is_too_quick(int32_t last_driven_um_s, int32_t measured_um) {
  w.slow_driven += last_driven_um_s - (w.slow_driven >> SLOW);
  const int32_t driven_um_s = w.slow_driven >> SLOW;
  w.went_nm[w.place % QUICK_PLACES] += driven_um_s;  // nm: um/s during a ms
  w.all_nm += driven_um_s;
  if (++w.place_ms < QUICK_EVERY_MS) return w.quick >= QUICK_TIMES;
  w.place_ms = 0;
  w.place = (uint8_t)(w.place + 1) % QUICK_PLACES;
  const int32_t way_um = measured_um - w.was_um[w.place];
  const int32_t driven_um = w.all_nm >> 10, beyond_um = QUICK_UM + SUPPLY_UM_S * QUICK_MS / 1000;
  const int32_t forward_um = (driven_um > 0 ? 2 * driven_um : 0) + beyond_um;
  const int32_t backward_um = (driven_um < 0 ? 2 * driven_um : 0) - beyond_um;
  w.was_um[w.place] = measured_um;
  w.all_nm -= w.went_nm[w.place];
  w.went_nm[w.place] = 0;
  if (w.filled < QUICK_PLACES)
    ++w.filled;
  else if (way_um > forward_um || way_um < backward_um)
    ++w.quick;
  else
    w.quick = 0;
  return w.quick >= QUICK_TIMES;
}

static uint8_t watch_rest(int32_t measured_um) {
  if (w.rest_ms < RUN_DOWN_MS) {
    ++w.rest_ms;
    w.from_um = measured_um;
  }
  w.direction = 0;
  return magnitude(measured_um - w.from_um) > UNDRIVEN_UM ? FOLLOW_RUNAWAY : FOLLOW_FINE;
}

static uint8_t is_wrong_way(int32_t seen_um) {
  w.wrong_ms = seen_um < -WRONG_SOON_UM ? w.wrong_ms + 1 : 0;
  return w.wrong_ms >= WRONG_SOON_MS || seen_um < -WRONG_WAY_UM;
}

static uint8_t is_still(int8_t direction, uint32_t driven_nm, int32_t measured_um) {
  w.still_nm += driven_nm;
  if (direction * (measured_um - w.went_on_um) > STILL_UM) {
    w.went_on_um = measured_um;
    w.still_nm = 0;
  }
  return w.still_nm >= STILL_NM;
}

static void watch_from(int32_t measured_um, int32_t slow_um) {
  w.from_um = measured_um;
  w.slow_from_um = slow_um;
  w.driven_nm = w.allowed_nm = 0;
}

// The speed that the bridge drives by the duty table, 0 if it does not drive; the stroke as it is measured, and the
// slow stroke, where small movements count.
static uint8_t watch(int32_t driven_um_s, int32_t measured_um, int32_t slow_um) {
  const int8_t direction = (driven_um_s > 0) - (driven_um_s < 0);
  if (is_too_quick(driven_um_s, slow_um)) return FOLLOW_RUNAWAY;
  if (direction == 0) return watch_rest(measured_um);
  w.rest_ms = 0;
  if (direction != w.direction) {
    w.direction = direction;
    watch_from(measured_um, slow_um);
    w.went_on_um = measured_um;
    w.still_nm = 0;
    w.wrong_ms = 0;
  }
  w.driven_nm += magnitude(driven_um_s);
  w.allowed_nm += 2 * magnitude(driven_um_s) + SUPPLY_UM_S;
  const int32_t seen_um = direction * (measured_um - w.from_um);
  if (is_wrong_way(direction * (slow_um - w.slow_from_um))) return FOLLOW_WRONG_WAY;
  if (seen_um > (w.allowed_nm >> 10) + TOO_FAR_UM) return FOLLOW_RUNAWAY;
  const uint8_t still = is_still(direction, magnitude(driven_um_s), measured_um);
  if (w.driven_nm < WATCH_NM) return still ? FOLLOW_STILL : seen_um > PROVEN_UM ? FOLLOW_PROVEN : FOLLOW_FINE;
  if (seen_um * LEAST_PART < (w.driven_nm >> 10)) return FOLLOW_NO_MOTION;
  watch_from(measured_um, slow_um);
  return FOLLOW_FINE;
}

// Where the motor has not the speed the plan waits for it, so that the program takes longer: for MOST_WAIT_MS, of which
// two ms of the plan give one back. So it takes half as long again and MOST_WAIT_MS at most; a motor that has less than
// two thirds of the speed falls behind.
#define MOST_WAIT_MS 500
static struct {
  int32_t stroke_nm;   // as planned: um/s during one ms are nm
  int32_t planned_um;  // of it, divided once per ms
  uint16_t bucket;     // what is used up of the wait, half ms
  uint16_t is_waiting;
  uint32_t waited_ms;
} p;

int32_t plant_planned_um(void) {
  return p.planned_um;
}

int32_t plant_stroke_um(void) {
  return analog_stroke_um();
}

uint32_t plant_drift_um(void) {
  return LAKE_POT_ERROR_UM;
}

void plant_know(int32_t um) {
  p.stroke_nm = um * 1000;
}

uint8_t plant_contradicts(int32_t um) {
  return magnitude(analog_stroke_um() - um) > LAKE_PLACE_UM;
}

void plant_begin(void) {
  memset(&p, 0, sizeof p);
  p.stroke_nm = LAKE_START_UM * 1000;
  p.planned_um = LAKE_START_UM;
  follow_begin();
}

motion_t plant_follow(int32_t planned_um_s, uint16_t counts) {
  (void)counts;
  is_limited = motor_counts() >= LAKE_PWM_PERIOD;
  const int32_t velocity_um_s = follow_speed(p.planned_um, planned_um_s, analog_stroke_um());
  const int8_t direction = (int8_t)((velocity_um_s > 0) - (velocity_um_s < 0));
  return motion_of(direction, counts_of(velocity_um_s), velocity_um_s);
}

// A program's until the motor has the speed for it, everything else until the bridge does what is asked for.
uint8_t plant_waits(const motion_t* wanted) {
  return machine.state == STATE_RUNNING ? p.is_waiting != 0 : motor_direction() != wanted->direction;
}

uint32_t plant_waited_ms(void) {
  return p.waited_ms;
}

int8_t plant_side_of_start(void) {
  return analog_stroke_um() < LAKE_START_UM ? 1 : -1;
}

uint8_t plant_has_arrived(int8_t side) {
  return side > 0 ? analog_stroke_um() >= LAKE_START_UM : analog_stroke_um() <= LAKE_START_UM;
}

// Nonzero once it has waited too long.
static uint8_t wait_for(const motion_t* wanted) {
  p.is_waiting = wanted->direction != 0 && lags;
  if (p.is_waiting) {
    ++p.waited_ms;
    p.bucket += 2;
  } else if (p.bucket > 0) {
    --p.bucket;
  }
  return p.bucket > 2 * MOST_WAIT_MS;
}

// A program's plan goes on unless it waits, and stands before and after it; otherwise the stroke is what the
// potentiometer says.
static void keep_plan(int32_t planned_um_s) {
  if (machine.state == STATE_RUNNING)
    p.stroke_nm += p.is_waiting ? 0 : planned_um_s;
  else if (machine.state != STATE_HOLD && machine.state != STATE_CHECKING_RUN)
    p.stroke_nm = analog_stroke_um() * 1000;
  p.planned_um = thousandth(p.stroke_nm);
}

uint8_t plant_turn(const motion_t* driven, const motion_t* wanted, int32_t planned_um_s) {
  keep_plan(planned_um_s);
  if (machine.state == STATE_FAULT) return 0;
  const uint8_t found = watch(driven->velocity_um_s, analog_stroke_um(), analog_slow_um());
  if (found == FOLLOW_NO_MOTION) state_fault(FAULT_NO_MOTION);
  if (found == FOLLOW_WRONG_WAY) state_fault(FAULT_WRONG_WAY);
  if (found == FOLLOW_RUNAWAY) state_fault(FAULT_RUNAWAY);
  if (found == FOLLOW_STILL && analog_is_without_current()) state_fault(FAULT_NO_CURRENT);
  if (machine.state == STATE_RUNNING &&
      (wait_for(wanted) || magnitude(p.planned_um - analog_stroke_um()) > LAKE_FOLLOWING_UM))
    state_fault(FAULT_FOLLOWING);
  return found == FOLLOW_PROVEN;
}

uint8_t plant_kept(kept_t what) {
  return kept_pass(&p, sizeof p, what);
}
