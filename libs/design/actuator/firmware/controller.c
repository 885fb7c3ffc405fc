#include "controller.h"

#include "analog.h"
#include "config.h"
#include "end_stops.h"
#include "follow.h"
#include "motor.h"
#include "portable.h"

// What is wanted of the motor in this ms.
typedef struct {
  int8_t direction;
  uint16_t counts;
  int32_t velocity_um_s;
  uint32_t spread_um_s;  // by which it may be slower, beside the tolerances
} motion_t;

static const motion_t kRest = {0, 0, 0, 0};

// Shared by interrupts and main loop; the main loop touches them in ATOMICALLY blocks only, which are barriers.
static uint32_t time_ms;
static state_t state;
static state_t held;  // what a hold goes on with
static knowledge_t knowledge;
static int32_t stroke_nm;         // um/s during one ms are nm
static uint32_t way_drift_nm;     // what the tolerance of the speed allows
static uint32_t lag_drift_nm[2];  // what lag allows: behind by speeding up, ahead by slowing down
static reply_t reply;
static uint16_t events;
static request_t request;
static int16_t request_counts;
static uint16_t request_ms;
static uint8_t hold_asked, resume_asked, abort_asked, heard;

static uint16_t silent_ms;
static uint32_t clock_ms;  // of the program, of homing, or of a jog
static uint32_t end_ms;
static motion_t jog;
static uint32_t pressed_way_nm;  // driven away from an end stop that is pressed all the while

#if LAKE_SEGMENT_COUNT > 0
static uint16_t segment_index;
static lake_segment segment;
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
#endif

static void fault(uint16_t what) {
  state = STATE_FAULT;
  knowledge = STROKE_UNKNOWN;
  events |= what;
}

#if LAKE_FEEDBACK
static int32_t planned_now_um;  // of stroke_nm, divided once per ms
#endif

static int32_t planned_um(void) {
#if LAKE_FEEDBACK
  return planned_now_um;
#else
  return stroke_nm / 1000;
#endif
}

#if LAKE_SEGMENT_COUNT > 0
// Where the actuator is, as well as that is known.
static int32_t stroke_um(void) {
  return LAKE_FEEDBACK ? analog_stroke_um() : planned_um();
}
#endif

static uint32_t drift_um(void) {
#if LAKE_FEEDBACK
  return LAKE_POT_ERROR_UM;
#endif
  return (way_drift_nm + (lag_drift_nm[0] > lag_drift_nm[1] ? lag_drift_nm[0] : lag_drift_nm[1])) / 1000;
}

static void begin(state_t next, uint32_t duration_ms) {
  state = next;
  clock_ms = 0;
  end_ms = duration_ms;
}

#if LAKE_SEGMENT_COUNT > 0
// A motion with the greatest speed that its duty can give by the duty table: between two nodes the upper one's, since
// the table rises; it may be as slow as the lower one's. Below the first duty that was measured nothing is known but
// that it is no faster.
static motion_t motion_of(int8_t direction, uint16_t counts) {
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

static uint8_t is_measured(int8_t direction, uint16_t counts) {
  return counts <= (direction < 0 ? LAKE_RETRACT_MOST_COUNTS : LAKE_EXTEND_MOST_COUNTS);
}
#else
static motion_t motion_of(int8_t direction, uint16_t counts) {
  const motion_t motion = {direction, counts, 0, 0};
  return motion;
}

static uint8_t is_measured(int8_t direction, uint16_t counts) {
  (void)direction, (void)counts;
  return 1;
}
#endif

static uint8_t end_stop_ahead(int8_t direction) {
  const uint8_t pressed = end_stops_pressed();
  return (direction > 0 && (pressed & END_STOP_EXTEND)) || (direction < 0 && (pressed & END_STOP_RETRACT));
}

#if LAKE_SEGMENT_COUNT > 0
// The linkage's end, where the actuator may be as far from the plan as the drift allows. At the other end the retract
// end stop comes first.
static uint8_t drift_reaches_end(void) {
  return LAKE_DRIFT_LIMITED && stroke_um() + (int32_t)drift_um() >= LAKE_UPPER_END_UM;
}
#endif

static uint8_t soft_limit_ahead(int8_t direction) {
#if LAKE_SEGMENT_COUNT > 0
  if (knowledge == STROKE_UNKNOWN) return 0;
  if (direction > 0) return stroke_um() >= LAKE_UPPER_LIMIT_UM + SOFT_LIMIT_SLACK_UM || drift_reaches_end();
  return direction < 0 && stroke_um() <= LAKE_LOWER_LIMIT_UM - SOFT_LIMIT_SLACK_UM;
#else
  (void)direction;
  return 0;
#endif
}

#if LAKE_SEGMENT_COUNT > 0
#if LAKE_FEEDBACK
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
#else
static uint8_t is_away_from(int32_t um) {
  (void)um;
  return 0;
}
static void begin_following(void) {}
#endif

static reply_t take_run(void) {
  if (state != STATE_IDLE) return REPLY_STATE;
  if (knowledge != STROKE_AT_START || is_away_from(LAKE_START_UM)) return REPLY_POSITION;
  begin_following();
  load_segment(0);
  knowledge = STROKE_ESTIMATED;
  begin(STATE_RUNNING, 0);
  return REPLY_OK;
}

static void begin_homing(uint8_t phase, uint32_t duration_ms) {
  home_phase = phase;
  begin(STATE_HOMING, duration_ms);
}

// Pressed, though the stroke is known to be somewhere else.
static uint8_t retract_stop_contradicts_stroke(void) {
  return end_stop_ahead(-1) && knowledge != STROKE_UNKNOWN &&
         stroke_um() - (int32_t)drift_um() > LAKE_HOME_UM + LAKE_STOP_TRAVEL_UM;
}

// Likewise the extend end stop, where its place is known.
static uint8_t extend_stop_contradicts_stroke(void) {
  return LAKE_EXTEND_STOP_UM > 0 && end_stop_ahead(1) && knowledge != STROKE_UNKNOWN &&
         stroke_um() + (int32_t)drift_um() < LAKE_EXTEND_STOP_UM - LAKE_STOP_TRAVEL_UM;
}

static uint8_t stop_contradicts_stroke(void) {
  return retract_stop_contradicts_stroke() || extend_stop_contradicts_stroke();
}

static reply_t take_home(void) {
  if (state != STATE_IDLE) return REPLY_STATE;
  const uint8_t stuck = stop_contradicts_stroke();
  knowledge = STROKE_UNKNOWN;
  if (stuck)
    fault(EVENT_FAULT_STUCK);
  else
    begin_homing(HOME_SEEK, LAKE_HOME_TIMEOUT_MS);
  return REPLY_OK;
}

static void know_stroke(int32_t um, knowledge_t known) {
  stroke_nm = um * 1000;
  way_drift_nm = LAKE_DRIFT_START_UM * 1000L;
  lag_drift_nm[0] = lag_drift_nm[1] = 0;
  knowledge = known;
}

static reply_t take_zero(void) {
  if (state != STATE_IDLE) return REPLY_STATE;
  if (is_away_from(LAKE_START_UM)) return REPLY_POSITION;
  know_stroke(LAKE_START_UM, STROKE_AT_START);
  return REPLY_OK;
}
#else
static reply_t take_run(void) {
  return REPLY_NO_PROGRAM;
}
static uint8_t stop_contradicts_stroke(void) {
  return 0;
}
static reply_t take_home(void) {
  return REPLY_NO_PROGRAM;
}
static reply_t take_zero(void) {
  return REPLY_NO_PROGRAM;
}
#endif

static reply_t take_jog(void) {
  const int8_t direction = request_counts < 0 ? -1 : 1;
  const uint16_t counts = direction * request_counts;
  if (state != STATE_IDLE) return REPLY_STATE;
  if (!is_measured(direction, counts)) return REPLY_BAD_NUMBER;
  if (end_stop_ahead(direction)) return REPLY_STOP_AHEAD;
  if (soft_limit_ahead(direction)) return REPLY_LIMIT_AHEAD;
  jog = motion_of(direction, counts);
  if (knowledge == STROKE_AT_START) knowledge = STROKE_ESTIMATED;
  begin(STATE_JOGGING, request_ms);
  return REPLY_OK;
}

static void reset(void) {
  state = STATE_IDLE;
  knowledge = STROKE_UNKNOWN;
  pressed_way_nm = 0;
#if LAKE_FEEDBACK
  follow_watch_begin();
#endif
}

static reply_t answer(request_t asked) {
  switch (asked) {
    case REQUEST_RUN:
      return take_run();
    case REQUEST_HOME:
      return take_home();
    case REQUEST_ZERO:
      return take_zero();
    case REQUEST_JOG:
      return take_jog();
    case REQUEST_STOP:
      if (state != STATE_FAULT) state = STATE_IDLE;
      return REPLY_OK;
    case REQUEST_RESET:
      reset();
      return REPLY_OK;
    default:
      return REPLY_NONE;
  }
}

static void take_request(void) {
  if (request == REQUEST_NONE) return;
  reply = answer(request);
  request = REQUEST_NONE;
  heard = 1;
}

static uint8_t is_moving(void) {
  return state != STATE_IDLE && state != STATE_HOLD && state != STATE_FAULT;
}

static void hold(void) {
  held = state;
  state = STATE_HOLD;
}

// A program keeps its place, everything else ends.
static void suspend(void) {
  if (state == STATE_RUNNING)
    hold();
  else if (is_moving())
    state = STATE_IDLE;
}

// Of a silent host: homing keeps its place as well, so that a person can take it in steps.
static void suspend_silent(void) {
  if (state == STATE_HOMING || state == STATE_POSITIONING)
    hold();
  else
    suspend();
}

static void take_realtime(void) {
  if (resume_asked && state == STATE_HOLD) state = held;
  if (hold_asked) suspend();
  if (abort_asked) reset();
  hold_asked = resume_asked = abort_asked = 0;
}

static void watch_host(void) {
  if (heard || !is_moving()) {
    silent_ms = 0;
  } else if (LAKE_COMMAND_TIMEOUT_MS > 0 && ++silent_ms >= LAKE_COMMAND_TIMEOUT_MS) {
    events |= EVENT_TIMEOUT;
    suspend_silent();
  }
  heard = 0;
}

// End stops that cannot be pressed as they are, told where nothing moves: is_allowed sees to it while something does.
static void watch_wires(void) {
  static uint8_t wrong_ms;
  const uint8_t both = end_stops_pressed() == (END_STOP_RETRACT | END_STOP_EXTEND);
  if (state == STATE_FAULT || is_moving() || !(both || stop_contradicts_stroke())) {
    wrong_ms = 0;
  } else if (++wrong_ms >= WIRE_WRONG_MS) {
    wrong_ms = 0;
    fault(both ? EVENT_FAULT_BOTH_STOPS : EVENT_FAULT_STUCK);
  }
}

static void watch_inputs(void) {
  const uint8_t wrong = analog_faults();
  if (state == STATE_FAULT || wrong == 0) return;
  fault(wrong & ANALOG_NO_SUPPLY    ? EVENT_FAULT_SUPPLY
        : wrong & ANALOG_NO_WIPER   ? EVENT_FAULT_WIPER
        : wrong & ANALOG_NO_CURRENT ? EVENT_FAULT_NO_CURRENT
                                    : EVENT_FAULT_OVERCURRENT);
}

static void finish(knowledge_t known) {
  state = STATE_IDLE;
  knowledge = known;
  events |= EVENT_DONE;
}

#if LAKE_SEGMENT_COUNT > 0
static motion_t run(void) {
  while (clock_ms >= segment.end_ms) {
    if (segment_index + 1 == LAKE_SEGMENT_COUNT) {
      finish(STROKE_ESTIMATED);
      return kRest;
    }
    load_segment(segment_index + 1);
  }
#if LAKE_FEEDBACK
  const int32_t velocity_um_s = follow_speed(planned_um(), segment.velocity_um_s, analog_stroke_um());
  const uint16_t counts = follow_counts(velocity_um_s);
#else
  const int32_t velocity_um_s = segment.velocity_um_s;
  const uint16_t counts = segment.counts;
#endif
  const int8_t direction = (velocity_um_s > 0) - (velocity_um_s < 0);
  const motion_t motion = {direction, counts, velocity_um_s, 0};
  return motion;
}

// Retracts until the end stop is pressed.
static motion_t seek(void) {
  if (end_stop_ahead(-1)) {
    if (home_phase == HOME_TOUCH) know_stroke(LAKE_HOME_UM, STROKE_ESTIMATED);
    if (home_phase == HOME_TOUCH && is_away_from(LAKE_HOME_UM)) {
      fault(EVENT_FAULT_WIPER);
      return kRest;
    }
    begin_homing(home_phase == HOME_TOUCH ? HOME_RELEASE : HOME_BACK_OFF, LAKE_BACK_OFF_MS);
    return kRest;
  }
  if (clock_ms >= end_ms) {
    fault(EVENT_FAULT_HOME);
    return kRest;
  }
  const motion_t motion = {-1, LAKE_HOME_COUNTS, -LAKE_HOME_SPEED_UM_S, 0};
  return motion;
}

static const motion_t kExtend = {1, LAKE_POSITION_COUNTS, LAKE_POSITION_SPEED_UM_S, 0};

// Extends until the end stop must have released.
static motion_t back_off(void) {
  if (clock_ms < end_ms) return kExtend;
  if (end_stop_ahead(-1)) {
    fault(EVENT_FAULT_STUCK);
    return kRest;
  }
  if (home_phase == HOME_BACK_OFF) {
    begin_homing(HOME_TOUCH, LAKE_TOUCH_TIMEOUT_MS);
    return kRest;
  }
  start_lies = LAKE_FEEDBACK ? (analog_stroke_um() < LAKE_START_UM ? 1 : -1) : (LAKE_POSITION_MS > 0 ? 1 : -1);
  begin(STATE_POSITIONING, POSITIONING_MS);
  return start_lies > 0 ? kExtend : kRest;
}

// Only an end stop that has been seen to release and to be pressed again, twice, is home: a broken wire looks pressed
// everywhere, and one that breaks after the first release like the second touch.
static motion_t home(void) {
  return home_phase == HOME_SEEK || home_phase == HOME_TOUCH ? seek() : back_off();
}

// Back to a start that lies before where the end stop was seen to release. There it may be pressed again, no farther
// from it than the drift: that, too, is the start.
static motion_t come_back(void) {
  if (!end_stop_ahead(-1)) {
    const motion_t motion = {-1, LAKE_HOME_COUNTS, -LAKE_HOME_SPEED_UM_S, 0};
    return motion;
  }
  if (stroke_um() - (int32_t)drift_um() > LAKE_START_UM)
    fault(EVENT_FAULT_STUCK);
  else
    finish(STROKE_AT_START);
  return kRest;
}

static uint8_t has_arrived(void) {
#if LAKE_FEEDBACK
  return start_lies > 0 ? analog_stroke_um() >= LAKE_START_UM : analog_stroke_um() <= LAKE_START_UM;
#else
  return clock_ms >= end_ms;
#endif
}

static motion_t position(void) {
  if (has_arrived()) {
    finish(STROKE_AT_START);
    return kRest;
  }
  if (clock_ms >= end_ms) {
    fault(EVENT_FAULT_NO_MOTION);
    return kRest;
  }
  return start_lies > 0 ? kExtend : come_back();
}
#else
static motion_t run(void) {
  return kRest;
}
static motion_t home(void) {
  return kRest;
}
static motion_t position(void) {
  return kRest;
}
#endif

static motion_t jogging(void) {
  if (clock_ms >= end_ms) {
    finish(knowledge);
    return kRest;
  }
  if (end_stop_ahead(jog.direction) || soft_limit_ahead(jog.direction)) {
    state = STATE_IDLE;
    events |= EVENT_JOG_LIMIT;
    return kRest;
  }
  return jog;
}

static motion_t wanted(void) {
  switch (state) {
    case STATE_RUNNING:
      return run();
    case STATE_HOMING:
      return home();
    case STATE_POSITIONING:
      return position();
    case STATE_JOGGING:
      return jogging();
    default:
      return kRest;
  }
}

// An end stop releases within its travel when the actuator moves away from it. A calibration firmware knows no speed
// and so no way.
static uint8_t is_stop_stuck(void) {
#if LAKE_SEGMENT_COUNT > 0
  return pressed_way_nm > LAKE_STOP_TRAVEL_UM * 1000UL;
#else
  return 0;
#endif
}

// The last word before the motor.
static uint8_t is_allowed(const motion_t* motion) {
  if (motion->direction == 0) return 1;
  if (end_stops_pressed() == (END_STOP_RETRACT | END_STOP_EXTEND))
    fault(EVENT_FAULT_BOTH_STOPS);
  else if (end_stop_ahead(motion->direction))
    fault(EVENT_FAULT_STOP);
  else if (is_stop_stuck())
    fault(EVENT_FAULT_STUCK);
  else if (state != STATE_JOGGING && soft_limit_ahead(motion->direction))
    fault(EVENT_FAULT_SOFT_LIMIT);
  return state != STATE_FAULT;
}

#if LAKE_SEGMENT_COUNT > 0 && !LAKE_FEEDBACK
// What the tolerances allow in this ms: a part of the way and what it may be less, and what the motor's lag loses as
// the speed rises, gains as it falls.
static void drift(int32_t velocity_um_s, uint32_t way_nm, uint32_t spread_nm) {
  static int32_t last_um_s;
  const int32_t change = velocity_um_s - last_um_s;
  last_um_s = velocity_um_s;
  uint32_t* const lag = &lag_drift_nm[change < 0];
  if (*lag < LAKE_DRIFT_MOST_NM) *lag += (uint32_t)(change < 0 ? -change : change) * LAKE_LAG_MS;
  if (way_drift_nm < LAKE_DRIFT_MOST_NM) way_drift_nm += spread_nm + (way_nm * LAKE_DRIFT_PER_1024 + 1023) / 1024;
}

#endif

#if LAKE_SEGMENT_COUNT > 0
static void move(const motion_t* motion) {
  const int32_t velocity_um_s = motion->velocity_um_s;
  const uint32_t way_nm = velocity_um_s < 0 ? -velocity_um_s : velocity_um_s;
#if !LAKE_FEEDBACK
  stroke_nm += velocity_um_s;
  drift(velocity_um_s, way_nm, motion->spread_um_s);
#endif
  if (way_nm == 0) return;
  if (end_stop_ahead(velocity_um_s > 0 ? -1 : 1))  // what lies behind
    pressed_way_nm += way_nm;
  else
    pressed_way_nm = 0;
}
#else
static void move(const motion_t* motion) {
  (void)motion;
}
#endif

#if LAKE_FEEDBACK
// A program's plan goes on whatever the actuator does; otherwise the stroke is what the potentiometer says.
static void keep_plan(void) {
  if (state == STATE_RUNNING)
    stroke_nm += segment.velocity_um_s;
  else if (state != STATE_HOLD)
    stroke_nm = analog_stroke_um() * 1000;
  planned_now_um = stroke_nm / 1000;
}

static void watch_motion(const motion_t* motion) {
  if (state == STATE_FAULT) return;
  const int32_t error_um = planned_um() - analog_stroke_um();
  switch (follow_watch(motor_direction() == 0 ? 0 : motion->velocity_um_s, analog_stroke_um())) {
    case FOLLOW_NO_MOTION:
      fault(EVENT_FAULT_NO_MOTION);
      break;
    case FOLLOW_WRONG_WAY:
      fault(EVENT_FAULT_WRONG_WAY);
      break;
    case FOLLOW_RUNAWAY:
      fault(EVENT_FAULT_RUNAWAY);
      break;
    default:
      if (state == STATE_RUNNING && (error_um > LAKE_FOLLOWING_UM || error_um < -LAKE_FOLLOWING_UM))
        fault(EVENT_FAULT_FOLLOWING);
      break;
  }
}
#endif

// What the bridge does now, and so the estimate. Without feedback a motion's clock stands still until the bridge does
// what it asks for, so that no brake costs stroke.
static void keep_books(const motion_t* motion) {
  move(motor_direction() == 0 ? &kRest : motion);
  const uint8_t follows = LAKE_FEEDBACK && state == STATE_RUNNING;
  if (is_moving() && (follows || motor_direction() == motion->direction)) ++clock_ms;
#if LAKE_FEEDBACK
  keep_plan();
  watch_motion(motion);
#endif
}

void controller_init(void) {
  time_ms = 0;
  reset();
  request = REQUEST_NONE;
  reply = REPLY_NONE;
  events = 0;
  hold_asked = resume_asked = abort_asked = heard = 0;
}

void controller_tick(void) {
  ++time_ms;
  end_stops_tick();
  analog_tick(motor_counts());
  take_realtime();
  take_request();
  watch_host();
  watch_wires();
  watch_inputs();
  motion_t motion = wanted();
  if (!is_allowed(&motion)) motion = kRest;
  motor_tick(motion.direction, motion.counts);
  keep_books(&motion);
}

void controller_request(request_t what, int16_t jog_counts, uint16_t jog_ms) {
  ATOMICALLY {
    request = what;
    request_counts = jog_counts;
    request_ms = jog_ms;
  }
}

void controller_hold(void) {
  hold_asked = 1;
}
void controller_resume(void) {
  resume_asked = 1;
}
void controller_abort(void) {
  abort_asked = 1;
}
void controller_heard(void) {
  heard = 1;
}

status_t controller_status(void) {
  status_t now;
  ATOMICALLY {
    now.time_ms = time_ms;
    now.stroke_um = planned_um();
    now.measured_um = analog_stroke_um();
    now.current_ma = analog_current_ma();
    now.drift_um = drift_um();
    now.counts = motor_counts();
    now.direction = motor_direction();
    now.state = state;
    now.knowledge = knowledge;
    now.end_stops = end_stops_pressed();
  }
  return now;
}

reply_t controller_take_reply(void) {
  reply_t taken;
  ATOMICALLY {
    taken = reply;
    reply = REPLY_NONE;
  }
  return taken;
}

uint16_t controller_take_events(void) {
  uint16_t taken;
  ATOMICALLY {
    taken = events;
    events = 0;
  }
  return taken;
}
