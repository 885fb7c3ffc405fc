#include "program.h"

#include "config.h"
#include "end_stops.h"
#include "plant.h"
#include "portable.h"

static struct {
  uint16_t index;
  lake_segment segment;
  uint8_t home_tries;  // that have failed
  int8_t start_lies;   // of where homing ended: 1 beyond, -1 before
} q;

// The end stop behind a motion. One that is pressed must release; one that a motion away from it presses shows that the
// motor turns the wrong way, or a broken wire. A way stays on the account until the end stop is seen released: a fault
// that is acknowledged does not give the same way once more.
static struct {
  uint32_t pressed_way_nm, free_way_nm;
  int8_t direction;
  uint8_t is_proven;  // the motor has been seen to turn as it is told
} behind;
#define WAY_MOST_NM 1000000000UL

// By the potentiometer it may take longer than by the duty table.
#define PLANNED_POSITIONING_MS (LAKE_POSITION_MS > 0 ? LAKE_POSITION_MS : LAKE_RETURN_MS)
#define POSITIONING_MS (LAKE_FEEDBACK ? 4 * PLANNED_POSITIONING_MS + 2000 : PLANNED_POSITIONING_MS)

static void load_segment(uint16_t index) {
  q.index = index;
  memcpy_P(&q.segment, &lake_segments[index], sizeof q.segment);
}

// Of a fault while homing that another attempt would only repeat.
static uint8_t has_failed_to_home(void) {
  if (!(STATES_HOMING & STATES_OF(machine.before_fault))) return 0;
  return machine.fault == FAULT_STUCK || machine.fault == FAULT_HOME || machine.fault == FAULT_WRONG_WAY ||
         machine.fault == FAULT_NO_MOTION;
}

void program_reset(void) {
  if (has_failed_to_home()) ++q.home_tries;
  plant_reset();
}

void program_init(void) {
  q.home_tries = 0;
  memset(&behind, 0, sizeof behind);
  program_reset();
}

uint8_t program_kept(kept_t what) {
  return plant_kept(what) & kept_pass(&q, sizeof q, what) & kept_pass(&behind, sizeof behind, what);
}

// A motion with the greatest speed that its duty can give by the duty table: between two nodes the upper one's, since
// the table rises; it may be as slow as the lower one's. Below the first duty that was measured nothing is known but
// that it is no faster.
motion_t program_jog(int8_t direction, uint16_t counts) {
  const uint8_t retracts = direction < 0;
  const uint32_t scaled = (uint32_t)counts * LAKE_SPEED_INTERVALS;
  const uint8_t node = scaled / LAKE_PWM_PERIOD;
  const uint8_t upper = node + (scaled % LAKE_PWM_PERIOD > 0);
  const uint8_t first = retracts ? LAKE_RETRACT_FIRST_NODE : LAKE_EXTEND_FIRST_NODE;
  const uint32_t most = plant_node_um_s(retracts, upper);
  const uint32_t least = node < first ? 0 : plant_node_um_s(retracts, node);
  const motion_t motion = {direction, counts, direction * (int32_t)most, most - least};
  return motion;
}

uint8_t program_is_measured(int8_t direction, uint16_t counts) {
  return counts <= (direction < 0 ? LAKE_RETRACT_MOST_COUNTS : LAKE_EXTEND_MOST_COUNTS);
}

// The linkage's end, where the actuator may be as far from the plan as the drift allows. At the other end the retract
// end stop comes first.
static uint8_t drift_reaches_end(void) {
  return LAKE_DRIFT_LIMITED && plant_stroke_um() + (int32_t)plant_drift_um() >= LAKE_UPPER_END_UM;
}

uint8_t program_soft_limit_ahead(int8_t direction) {
  if (machine.knowledge == STROKE_UNKNOWN) return 0;
  if (direction > 0) return plant_stroke_um() >= LAKE_UPPER_LIMIT_UM + SOFT_LIMIT_SLACK_UM || drift_reaches_end();
  return direction < 0 && plant_stroke_um() <= LAKE_LOWER_LIMIT_UM - SOFT_LIMIT_SLACK_UM;
}

// A plan ends at the soft limit. What is measured passes it by noise and by the loop's error: three quarters of the way
// to the linkage's end are room for that, and the motor rests there meanwhile.
#define BEYOND_UM ((LAKE_UPPER_END_UM - LAKE_UPPER_LIMIT_UM) * 3 / 4)
#define HARD_LIMIT_UM (LAKE_UPPER_LIMIT_UM + (BEYOND_UM > LAKE_LEAST_BEYOND_UM ? BEYOND_UM : LAKE_LEAST_BEYOND_UM))

uint8_t program_hard_limit_ahead(int8_t direction) {
  if (!LAKE_FEEDBACK) return program_soft_limit_ahead(direction);
  if (machine.knowledge == STROKE_UNKNOWN) return 0;
  if (direction > 0) return plant_stroke_um() >= HARD_LIMIT_UM;
  return direction < 0 && plant_stroke_um() <= LAKE_LOWER_LIMIT_UM - LAKE_PLACE_UM;
}

reply_t program_take_run(void) {
  if (!LAKE_HAS_PROGRAM) return REPLY_NO_PROGRAM;
  if (machine.knowledge != STROKE_AT_START || plant_contradicts(LAKE_START_UM)) return REPLY_POSITION;
  plant_begin();
  load_segment(0);
  machine.knowledge = STROKE_ESTIMATED;
  return REPLY_OK;
}

static void next_phase(event_t event, uint32_t duration_ms) {
  state_on(event);
  machine.end_ms = duration_ms;
}

// Pressed, though the stroke is known to be somewhere else.
static uint8_t retract_stop_contradicts_stroke(void) {
  return state_end_stop_ahead(-1) && machine.knowledge != STROKE_UNKNOWN &&
         plant_stroke_um() - (int32_t)plant_drift_um() > LAKE_HOME_UM + LAKE_STOP_TRAVEL_UM;
}

// Likewise the extend end stop, where its place is known.
static uint8_t extend_stop_contradicts_stroke(void) {
  return LAKE_EXTEND_STOP_UM > 0 && state_end_stop_ahead(1) && machine.knowledge != STROKE_UNKNOWN &&
         plant_stroke_um() + (int32_t)plant_drift_um() < LAKE_EXTEND_STOP_UM - LAKE_STOP_TRAVEL_UM;
}

uint8_t program_stop_contradicts_stroke(void) {
  return retract_stop_contradicts_stroke() || extend_stop_contradicts_stroke();
}

// As far as the end stop may be away, at the speeds' tolerance; measured, the guard below home comes before the time
// does.
static uint32_t seeking_ms(void) {
  if (!LAKE_FEEDBACK && machine.knowledge == STROKE_UNKNOWN) return LAKE_HOME_TIMEOUT_MS;
  int32_t way_um = plant_stroke_um() + (int32_t)plant_drift_um() + LAKE_CHECK_UM - LAKE_HOME_UM;
  if (way_um < LAKE_CHECK_UM) way_um = LAKE_CHECK_UM;
  way_um += way_um / 1024 * LAKE_DRIFT_PER_1024;
  return (LAKE_FEEDBACK ? 5000 : 1000) * (uint32_t)way_um / LAKE_HOME_SPEED_UM_S + (LAKE_FEEDBACK ? 200 : 0);
}

reply_t program_take_home(void) {
  if (!LAKE_HAS_PROGRAM) return REPLY_NO_PROGRAM;
  if (q.home_tries >= HOME_TRIES) return REPLY_TRIES;
  if (program_stop_contradicts_stroke()) state_fault(FAULT_STUCK);
  machine.end_ms = seeking_ms();
  machine.knowledge = STROKE_UNKNOWN;
  return REPLY_OK;
}

static void know_stroke(int32_t um, knowledge_t known) {
  plant_know(um);
  machine.knowledge = known;
}

reply_t program_take_zero(void) {
  if (!LAKE_HAS_PROGRAM) return REPLY_NO_PROGRAM;
  if (plant_contradicts(LAKE_START_UM)) return REPLY_POSITION;
  know_stroke(LAKE_START_UM, STROKE_AT_START);
  return REPLY_OK;
}

// Where the end stop belongs, it is no fault that it is met. In open loop the drift is no excuse: a motor that comes so
// early or late is not the duty table's.
static uint8_t is_at_stop(int8_t direction) {
  if (!state_end_stop_ahead(direction)) return 0;
  const int32_t about_um = STOP_PLACE_UM + (LAKE_FEEDBACK ? (int32_t)plant_drift_um() : 0);
  if (direction < 0) return plant_stroke_um() - about_um <= LAKE_HOME_UM;
  return LAKE_EXTEND_STOP_UM > 0 && plant_stroke_um() + about_um >= LAKE_EXTEND_STOP_UM;
}

// At an end stop, and where the measured stroke has reached a limit, the motor rests while the program goes on.
static motion_t within_room(motion_t motion) {
  const int8_t direction = motion.direction;
  if (direction == 0) return motion;
  const uint8_t is_at_limit = LAKE_FEEDBACK && program_soft_limit_ahead(direction);
  return is_at_limit || is_at_stop(direction) ? motion_rest() : motion;
}

motion_t program_run(void) {
  while (machine.clock_ms >= q.segment.end_ms) {
    if (q.index + 1 >= LAKE_SEGMENT_COUNT) {
      state_finish(STROKE_ESTIMATED);
      if (plant_waited_ms() > 0) machine.news |= NEWS_WAITED;
      return motion_rest();
    }
    load_segment(q.index + 1);
  }
  return within_room(plant_follow(q.segment.velocity_um_s, q.segment.counts));
}

static motion_t extend(void) {
  return motion_of(1, LAKE_POSITION_COUNTS, LAKE_POSITION_SPEED_UM_S);
}

static motion_t retract(void) {
  return motion_of(-1, LAKE_HOME_COUNTS, -LAKE_HOME_SPEED_UM_S);
}

motion_t program_careful(motion_t motion) {
  if (behind.is_proven || !state_end_stop_ahead(-motion.direction)) return motion;
  const uint16_t counts = motion.direction < 0 ? LAKE_RETRACT_CREEP_COUNTS : LAKE_EXTEND_CREEP_COUNTS;
  if (motion.counts <= counts) return motion;
  motion.counts = counts;
  motion.velocity_um_s = motion.direction < 0 ? -LAKE_RETRACT_CREEP_UM_S : LAKE_EXTEND_CREEP_UM_S;
  return motion;
}

static motion_t home_fault(fault_t what) {
  state_fault(what);
  return motion_rest();
}

// The linkage's dead point, where a potentiometer sees that the end stop has not come.
static uint8_t has_passed_home(void) {
  return LAKE_FEEDBACK && plant_stroke_um() < LAKE_HOME_GUARD_UM;
}

// Retracts until the end stop is pressed.
static motion_t seek(void) {
  if (state_end_stop_ahead(-1)) {
    // It was free before: pressed by a motion towards it.
    if (machine.clock_ms > 0) behind.is_proven = 1;
    if (machine.state == STATE_TOUCHING) {
      know_stroke(LAKE_HOME_UM, STROKE_ESTIMATED);
      if (plant_contradicts(LAKE_HOME_UM)) return home_fault(FAULT_WIPER);
    }
    next_phase(ON_PRESSED, LAKE_BACK_OFF_MS);
    return motion_rest();
  }
  if (machine.clock_ms >= machine.end_ms || has_passed_home()) return home_fault(FAULT_HOME);
  return program_careful(retract());
}

// Off an end stop that was pressed from the beginning, as long as nothing has shown which way the motor turns.
static motion_t prove(void) {
  if (state_end_stop_ahead(-1) && !behind.is_proven) return program_careful(extend());
  next_phase(ON_DONE, LAKE_BACK_OFF_MS);
  return extend();
}

// Extends until the end stop must have released.
static motion_t back_off(void) {
  if (machine.clock_ms < machine.end_ms) return extend();
  if (state_end_stop_ahead(-1)) return home_fault(FAULT_STUCK);
  if (machine.state == STATE_BACKING_OFF) {
    next_phase(ON_DONE, LAKE_TOUCH_TIMEOUT_MS);
    return motion_rest();
  }
  q.start_lies = plant_side_of_start();
  next_phase(ON_DONE, POSITIONING_MS);
  return q.start_lies > 0 ? extend() : motion_rest();
}

static void arrive(void) {
  q.home_tries = 0;
  state_finish(STROKE_AT_START);
}

// Back to a start that lies before where the end stop was seen to release. There it may be pressed again, no farther
// from it than the drift: that, too, is the start.
static motion_t come_back(void) {
  if (!state_end_stop_ahead(-1)) return retract();
  if (plant_stroke_um() - (int32_t)plant_drift_um() > LAKE_START_UM) return home_fault(FAULT_STUCK);
  arrive();
  return motion_rest();
}

static motion_t position(void) {
  if (plant_has_arrived(q.start_lies)) {
    arrive();
    return motion_rest();
  }
  if (machine.clock_ms >= machine.end_ms) return home_fault(FAULT_NO_MOTION);
  return q.start_lies > 0 ? extend() : come_back();
}

// Only an end stop that has been seen to release and to be pressed again, twice, is home: a broken wire looks pressed
// everywhere, and one that breaks after the first release like the second touch.
motion_t program_home(void) {
  switch (machine.state) {
    case STATE_SEEKING:
    case STATE_TOUCHING:
      return seek();
    case STATE_PROVING:
      return prove();
    case STATE_BACKING_OFF:
    case STATE_RELEASING:
      return back_off();
    case STATE_POSITIONING:
      return position();
    default:
      return motion_rest();
  }
}

uint8_t program_stop_is_stuck(void) {
  return behind.pressed_way_nm > 1000UL * (behind.is_proven ? LAKE_STOP_TRAVEL_UM : LAKE_CHECK_UM);
}

static void watch_stop_behind(int32_t velocity_um_s) {
  const int8_t direction = (velocity_um_s > 0) - (velocity_um_s < 0);
  const uint32_t way_nm = velocity_um_s < 0 ? -velocity_um_s : velocity_um_s;
  if (direction == 0) {
    if (end_stops_pressed() == 0) behind.pressed_way_nm = 0;
    return;
  }
  if (direction != behind.direction) behind.free_way_nm = 0;
  behind.direction = direction;
  if (!state_end_stop_ahead(-direction)) {
    if (behind.pressed_way_nm > 0) behind.is_proven = 1;
    behind.pressed_way_nm = 0;
    if (behind.free_way_nm < WAY_MOST_NM) behind.free_way_nm += way_nm;
  } else if (behind.free_way_nm >= 1000UL * FREE_UM) {
    behind.pressed_way_nm = WAY_MOST_NM;
  } else if (behind.pressed_way_nm < WAY_MOST_NM) {
    behind.pressed_way_nm += way_nm;
  }
}

void program_keep_books(const motion_t* driven, const motion_t* wanted) {
  watch_stop_behind(driven->velocity_um_s);
  if (plant_turn(driven, wanted, q.segment.velocity_um_s)) behind.is_proven = 1;
}
