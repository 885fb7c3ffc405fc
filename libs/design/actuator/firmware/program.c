#include "program.h"

#include "analog.h"
#include "config.h"
#include "follow.h"
#include "motor.h"
#include "portable.h"

#if LAKE_SEGMENT_COUNT > 0

static uint16_t segment_index;
static lake_segment segment;
static int32_t stroke_nm;         // um/s during one ms are nm
static uint32_t way_drift_nm;     // what the tolerance of the speed allows
static uint32_t lag_drift_nm[2];  // what lag allows: behind by speeding up, ahead by slowing down
static uint32_t pressed_way_nm;   // driven away from an end stop that is pressed all the while
enum { HOME_SEEK, HOME_BACK_OFF, HOME_TOUCH, HOME_RELEASE };
static uint8_t home_phase;
static int8_t start_lies;  // of where homing ended: 1 beyond, -1 before

// By the potentiometer it may take longer than by the duty table.
#define PLANNED_POSITIONING_MS (LAKE_POSITION_MS > 0 ? LAKE_POSITION_MS : LAKE_RETURN_MS)
#define POSITIONING_MS (LAKE_FEEDBACK ? 4 * PLANNED_POSITIONING_MS + 2000 : PLANNED_POSITIONING_MS)

static void load_segment(uint16_t index) {
  segment_index = index;
  memcpy_P(&segment, &lake_segments[index], sizeof segment);
}

#if LAKE_FEEDBACK
static int32_t planned_now_um;  // of stroke_nm, divided once per ms

int32_t program_stroke_um(void) {
  return planned_now_um;
}

// Where the actuator is, as well as that is known.
static int32_t stroke_um(void) {
  return analog_stroke_um();
}

uint32_t program_drift_um(void) {
  return LAKE_POT_ERROR_UM;
}

// What the potentiometer has to say of a place that is known otherwise.
static uint8_t is_away_from(int32_t um) {
  const int32_t apart_um = analog_stroke_um() - um;
  return apart_um > LAKE_PLACE_UM || apart_um < -LAKE_PLACE_UM;
}

static void begin_following(void) {
  stroke_nm = LAKE_START_UM * 1000;
  planned_now_um = LAKE_START_UM;
  follow_begin();
}

static motion_t follow_segment(void) {
  const int32_t velocity_um_s = follow_speed(planned_now_um, segment.velocity_um_s, analog_stroke_um());
  const int8_t direction = (velocity_um_s > 0) - (velocity_um_s < 0);
  const motion_t motion = {direction, follow_counts(velocity_um_s), velocity_um_s, 0};
  return motion;
}

static uint8_t has_arrived(void) {
  return start_lies > 0 ? analog_stroke_um() >= LAKE_START_UM : analog_stroke_um() <= LAKE_START_UM;
}

static void count_way(const motion_t* driven) {
  (void)driven;
}

// A program's plan goes on whatever the actuator does; otherwise the stroke is what the potentiometer says.
static void keep_plan(void) {
  if (machine.state == STATE_RUNNING)
    stroke_nm += segment.velocity_um_s;
  else if (machine.state != STATE_HOLD)
    stroke_nm = analog_stroke_um() * 1000;
  planned_now_um = stroke_nm / 1000;
}

static void watch_motion(const motion_t* motion) {
  if (machine.state == STATE_FAULT) return;
  const int32_t error_um = planned_now_um - analog_stroke_um();
  switch (follow_watch(motor_direction() == 0 ? 0 : motion->velocity_um_s, analog_stroke_um())) {
    case FOLLOW_NO_MOTION:
      state_fault(FAULT_NO_MOTION);
      break;
    case FOLLOW_WRONG_WAY:
      state_fault(FAULT_WRONG_WAY);
      break;
    case FOLLOW_RUNAWAY:
      state_fault(FAULT_RUNAWAY);
      break;
    default:
      if (machine.state == STATE_RUNNING && (error_um > LAKE_FOLLOWING_UM || error_um < -LAKE_FOLLOWING_UM))
        state_fault(FAULT_FOLLOWING);
      break;
  }
}
#else
int32_t program_stroke_um(void) {
  return stroke_nm / 1000;
}

static int32_t stroke_um(void) {
  return program_stroke_um();
}

uint32_t program_drift_um(void) {
  return (way_drift_nm + (lag_drift_nm[0] > lag_drift_nm[1] ? lag_drift_nm[0] : lag_drift_nm[1])) / 1000;
}

static uint8_t is_away_from(int32_t um) {
  (void)um;
  return 0;
}

static void begin_following(void) {}

static motion_t follow_segment(void) {
  const int32_t velocity_um_s = segment.velocity_um_s;
  const int8_t direction = (velocity_um_s > 0) - (velocity_um_s < 0);
  const motion_t motion = {direction, segment.counts, velocity_um_s, 0};
  return motion;
}

static uint8_t has_arrived(void) {
  return machine.clock_ms >= machine.end_ms;
}

// What the tolerances allow in this ms: a part of the way and what it may be less, and what the motor's lag loses as
// the speed rises, gains as it falls.
static void count_way(const motion_t* driven) {
  static int32_t last_um_s;
  const int32_t velocity_um_s = driven->velocity_um_s;
  const uint32_t way_nm = velocity_um_s < 0 ? -velocity_um_s : velocity_um_s;
  const int32_t change = velocity_um_s - last_um_s;
  last_um_s = velocity_um_s;
  stroke_nm += velocity_um_s;
  uint32_t* const lag = &lag_drift_nm[change < 0];
  if (*lag < LAKE_DRIFT_MOST_NM) *lag += (uint32_t)(change < 0 ? -change : change) * LAKE_LAG_MS;
  if (way_drift_nm < LAKE_DRIFT_MOST_NM)
    way_drift_nm += driven->spread_um_s + (way_nm * LAKE_DRIFT_PER_1024 + 1023) / 1024;
}

static void keep_plan(void) {}
static void watch_motion(const motion_t* motion) {
  (void)motion;
}
#endif

void program_reset(void) {
  pressed_way_nm = 0;
#if LAKE_FEEDBACK
  follow_watch_begin();
#endif
}

// A motion with the greatest speed that its duty can give by the duty table: between two nodes the upper one's, since
// the table rises; it may be as slow as the lower one's. Below the first duty that was measured nothing is known but
// that it is no faster.
motion_t program_jog(int8_t direction, uint16_t counts) {
  const uint32_t* row = lake_speed_um_s[direction < 0];
  const uint32_t scaled = (uint32_t)counts * LAKE_SPEED_INTERVALS;
  const uint8_t node = scaled / LAKE_PWM_PERIOD;
  const uint8_t upper = node + (scaled % LAKE_PWM_PERIOD > 0);
  const uint8_t first = direction < 0 ? LAKE_RETRACT_FIRST_NODE : LAKE_EXTEND_FIRST_NODE;
  const uint32_t most = pgm_read_dword(&row[upper]);
  const uint32_t least = node < first ? 0 : pgm_read_dword(&row[node]);
  const motion_t motion = {direction, counts, direction * (int32_t)most, most - least};
  return motion;
}

uint8_t program_is_measured(int8_t direction, uint16_t counts) {
  return counts <= (direction < 0 ? LAKE_RETRACT_MOST_COUNTS : LAKE_EXTEND_MOST_COUNTS);
}

// The linkage's end, where the actuator may be as far from the plan as the drift allows. At the other end the retract
// end stop comes first.
static uint8_t drift_reaches_end(void) {
  return LAKE_DRIFT_LIMITED && stroke_um() + (int32_t)program_drift_um() >= LAKE_UPPER_END_UM;
}

uint8_t program_soft_limit_ahead(int8_t direction) {
  if (machine.knowledge == STROKE_UNKNOWN) return 0;
  if (direction > 0) return stroke_um() >= LAKE_UPPER_LIMIT_UM + SOFT_LIMIT_SLACK_UM || drift_reaches_end();
  return direction < 0 && stroke_um() <= LAKE_LOWER_LIMIT_UM - SOFT_LIMIT_SLACK_UM;
}

reply_t program_take_run(void) {
  if (machine.state != STATE_IDLE) return REPLY_STATE;
  if (machine.knowledge != STROKE_AT_START || is_away_from(LAKE_START_UM)) return REPLY_POSITION;
  begin_following();
  load_segment(0);
  machine.knowledge = STROKE_ESTIMATED;
  state_begin(STATE_RUNNING, 0);
  return REPLY_OK;
}

static void begin_homing(uint8_t phase, uint32_t duration_ms) {
  home_phase = phase;
  state_begin(STATE_HOMING, duration_ms);
}

// Pressed, though the stroke is known to be somewhere else.
static uint8_t retract_stop_contradicts_stroke(void) {
  return state_end_stop_ahead(-1) && machine.knowledge != STROKE_UNKNOWN &&
         stroke_um() - (int32_t)program_drift_um() > LAKE_HOME_UM + LAKE_STOP_TRAVEL_UM;
}

// Likewise the extend end stop, where its place is known.
static uint8_t extend_stop_contradicts_stroke(void) {
  return LAKE_EXTEND_STOP_UM > 0 && state_end_stop_ahead(1) && machine.knowledge != STROKE_UNKNOWN &&
         stroke_um() + (int32_t)program_drift_um() < LAKE_EXTEND_STOP_UM - LAKE_STOP_TRAVEL_UM;
}

uint8_t program_stop_contradicts_stroke(void) {
  return retract_stop_contradicts_stroke() || extend_stop_contradicts_stroke();
}

reply_t program_take_home(void) {
  if (machine.state != STATE_IDLE) return REPLY_STATE;
  const uint8_t stuck = program_stop_contradicts_stroke();
  machine.knowledge = STROKE_UNKNOWN;
  if (stuck)
    state_fault(FAULT_STUCK);
  else
    begin_homing(HOME_SEEK, LAKE_HOME_TIMEOUT_MS);
  return REPLY_OK;
}

static void know_stroke(int32_t um, knowledge_t known) {
  stroke_nm = um * 1000;
  way_drift_nm = LAKE_DRIFT_START_UM * 1000L;
  lag_drift_nm[0] = lag_drift_nm[1] = 0;
  machine.knowledge = known;
}

reply_t program_take_zero(void) {
  if (machine.state != STATE_IDLE) return REPLY_STATE;
  if (is_away_from(LAKE_START_UM)) return REPLY_POSITION;
  know_stroke(LAKE_START_UM, STROKE_AT_START);
  return REPLY_OK;
}

motion_t program_run(void) {
  while (machine.clock_ms >= segment.end_ms) {
    if (segment_index + 1 == LAKE_SEGMENT_COUNT) {
      state_finish(STROKE_ESTIMATED);
      return kRest;
    }
    load_segment(segment_index + 1);
  }
  return follow_segment();
}

// Retracts until the end stop is pressed.
static motion_t seek(void) {
  if (state_end_stop_ahead(-1)) {
    if (home_phase == HOME_TOUCH) know_stroke(LAKE_HOME_UM, STROKE_ESTIMATED);
    if (home_phase == HOME_TOUCH && is_away_from(LAKE_HOME_UM)) {
      state_fault(FAULT_WIPER);
      return kRest;
    }
    begin_homing(home_phase == HOME_TOUCH ? HOME_RELEASE : HOME_BACK_OFF, LAKE_BACK_OFF_MS);
    return kRest;
  }
  if (machine.clock_ms >= machine.end_ms) {
    state_fault(FAULT_HOME);
    return kRest;
  }
  const motion_t motion = {-1, LAKE_HOME_COUNTS, -LAKE_HOME_SPEED_UM_S, 0};
  return motion;
}

static const motion_t kExtend = {1, LAKE_POSITION_COUNTS, LAKE_POSITION_SPEED_UM_S, 0};

// Extends until the end stop must have released.
static motion_t back_off(void) {
  if (machine.clock_ms < machine.end_ms) return kExtend;
  if (state_end_stop_ahead(-1)) {
    state_fault(FAULT_STUCK);
    return kRest;
  }
  if (home_phase == HOME_BACK_OFF) {
    begin_homing(HOME_TOUCH, LAKE_TOUCH_TIMEOUT_MS);
    return kRest;
  }
  start_lies = LAKE_FEEDBACK ? (analog_stroke_um() < LAKE_START_UM ? 1 : -1) : (LAKE_POSITION_MS > 0 ? 1 : -1);
  state_begin(STATE_POSITIONING, POSITIONING_MS);
  return start_lies > 0 ? kExtend : kRest;
}

// Only an end stop that has been seen to release and to be pressed again, twice, is home: a broken wire looks pressed
// everywhere, and one that breaks after the first release like the second touch.
motion_t program_home(void) {
  return home_phase == HOME_SEEK || home_phase == HOME_TOUCH ? seek() : back_off();
}

// Back to a start that lies before where the end stop was seen to release. There it may be pressed again, no farther
// from it than the drift: that, too, is the start.
static motion_t come_back(void) {
  if (!state_end_stop_ahead(-1)) {
    const motion_t motion = {-1, LAKE_HOME_COUNTS, -LAKE_HOME_SPEED_UM_S, 0};
    return motion;
  }
  if (stroke_um() - (int32_t)program_drift_um() > LAKE_START_UM)
    state_fault(FAULT_STUCK);
  else
    state_finish(STROKE_AT_START);
  return kRest;
}

motion_t program_position(void) {
  if (has_arrived()) {
    state_finish(STROKE_AT_START);
    return kRest;
  }
  if (machine.clock_ms >= machine.end_ms) {
    state_fault(FAULT_NO_MOTION);
    return kRest;
  }
  return start_lies > 0 ? kExtend : come_back();
}

// An end stop releases within its travel when the actuator moves away from it.
uint8_t program_stop_is_stuck(void) {
  return pressed_way_nm > LAKE_STOP_TRAVEL_UM * 1000UL;
}

void program_keep_books(const motion_t* driven, const motion_t* wanted) {
  const int32_t velocity_um_s = driven->velocity_um_s;
  count_way(driven);
  if (velocity_um_s != 0 && state_end_stop_ahead(velocity_um_s > 0 ? -1 : 1))  // what lies behind
    pressed_way_nm += velocity_um_s < 0 ? -velocity_um_s : velocity_um_s;
  else if (velocity_um_s != 0)
    pressed_way_nm = 0;
  keep_plan();
  watch_motion(wanted);
}

#endif
