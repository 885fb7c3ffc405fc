#include "controller.h"

#include <avr/pgmspace.h>
#include <util/atomic.h>

#include "config.h"
#include "end_stops.h"
#include "motor.h"

// What is wanted of the motor in this ms.
typedef struct {
  int8_t direction;
  uint16_t counts;
  int32_t velocity_um_s;
} motion_t;

static const motion_t kRest = {0, 0, 0};

static volatile uint32_t time_ms;
static volatile state_t state;
static volatile knowledge_t knowledge;
static volatile int32_t stroke_nm;  // um/s during one ms are nm
static volatile event_t event;
static volatile request_t request;
static volatile int16_t request_counts;
static volatile uint16_t request_ms;

static uint32_t clock_ms;  // of the program, of homing, or of a jog
static uint32_t end_ms;
static motion_t jog;

#if LAKE_SEGMENT_COUNT > 0
static uint16_t segment_index;
static lake_segment segment;

static void load_segment(uint16_t index) {
  segment_index = index;
  memcpy_P(&segment, &lake_segments[index], sizeof segment);
}
#endif

static void fault(event_t what) {
  state = STATE_FAULT;
  knowledge = STROKE_UNKNOWN;
  event = what;
}

static int32_t stroke_um(void) {
  return stroke_nm / 1000;
}

static void begin(state_t next, uint32_t duration_ms) {
  state = next;
  clock_ms = 0;
  end_ms = duration_ms;
  event = EVENT_OK;
}

// The speed of a duty by the duty table, linear between its nodes.
static int32_t speed_um_s(int8_t direction, uint16_t counts) {
#if LAKE_SEGMENT_COUNT > 0
  const uint32_t* row = lake_speed_um_s[direction < 0];
  const uint32_t scaled = (uint32_t)counts * LAKE_SPEED_INTERVALS;
  const uint8_t node = scaled / LAKE_PWM_PERIOD;
  const uint32_t low = pgm_read_dword(&row[node]);
  if (node >= LAKE_SPEED_INTERVALS) return direction * (int32_t)low;
  const uint32_t high = pgm_read_dword(&row[node + 1]);
  const uint32_t rest = scaled % LAKE_PWM_PERIOD;
  return direction *
         (int32_t)(low + (high - low) * rest / LAKE_PWM_PERIOD);  // speeds are below 1 m/s, so 32 bits suffice
#else
  (void)counts;
  return direction * 0;
#endif
}

static uint8_t end_stop_ahead(int8_t direction) {
  const uint8_t pressed = end_stops_pressed();
  return (direction > 0 && (pressed & END_STOP_EXTEND)) || (direction < 0 && (pressed & END_STOP_RETRACT));
}

static uint8_t soft_limit_ahead(int8_t direction) {
#if LAKE_SEGMENT_COUNT > 0
  if (knowledge == STROKE_UNKNOWN) return 0;
  return (direction > 0 && stroke_um() >= LAKE_UPPER_LIMIT_UM + SOFT_LIMIT_SLACK_UM) ||
         (direction < 0 && stroke_um() <= LAKE_LOWER_LIMIT_UM - SOFT_LIMIT_SLACK_UM);
#else
  (void)direction;
  return 0;
#endif
}

#if LAKE_SEGMENT_COUNT > 0
static void take_start(void) {
  if (state == STATE_PAUSED) {
    state = STATE_RUNNING;
    event = EVENT_OK;
  } else if (state != STATE_IDLE) {
    event = EVENT_REFUSED_STATE;
  } else if (knowledge != STROKE_AT_START) {
    event = EVENT_REFUSED_POSITION;
  } else {
    load_segment(0);
    knowledge = STROKE_ESTIMATED;
    begin(STATE_RUNNING, 0);
  }
}

static void take_home(void) {
  if (state != STATE_IDLE) {
    event = EVENT_REFUSED_STATE;
    return;
  }
  knowledge = STROKE_UNKNOWN;
  begin(STATE_HOMING, LAKE_HOME_TIMEOUT_MS);
}

static void take_zero(void) {
  if (state != STATE_IDLE) {
    event = EVENT_REFUSED_STATE;
    return;
  }
  stroke_nm = LAKE_START_UM * 1000L;
  knowledge = STROKE_AT_START;
  event = EVENT_OK;
}
#else
static void take_start(void) {
  event = EVENT_REFUSED_PROGRAM;
}
static void take_home(void) {
  event = EVENT_REFUSED_PROGRAM;
}
static void take_zero(void) {
  event = EVENT_REFUSED_PROGRAM;
}
#endif

static void take_jog(void) {
  const int8_t direction = request_counts < 0 ? -1 : 1;
  if (state != STATE_IDLE) {
    event = EVENT_REFUSED_STATE;
  } else if (end_stop_ahead(direction)) {
    event = EVENT_REFUSED_STOP;
  } else if (soft_limit_ahead(direction)) {
    event = EVENT_REFUSED_LIMIT;
  } else {
    jog.direction = direction;
    jog.counts = direction * request_counts;
    jog.velocity_um_s = speed_um_s(direction, jog.counts);
    if (knowledge == STROKE_AT_START) knowledge = STROKE_ESTIMATED;
    begin(STATE_JOGGING, request_ms);
  }
}

static void take_request(void) {
  const request_t asked = request;
  request = REQUEST_NONE;
  switch (asked) {
    case REQUEST_NONE:
      return;
    case REQUEST_START:
      take_start();
      return;
    case REQUEST_HOME:
      take_home();
      return;
    case REQUEST_ZERO:
      take_zero();
      return;
    case REQUEST_JOG:
      take_jog();
      return;
    case REQUEST_PAUSE:
      if (state == STATE_RUNNING) state = STATE_PAUSED;
      event = state == STATE_PAUSED ? EVENT_OK : EVENT_REFUSED_STATE;
      return;
    case REQUEST_STOP:
      if (state != STATE_FAULT) state = STATE_IDLE;
      event = EVENT_OK;
      return;
    case REQUEST_RESET:
      state = STATE_IDLE;
      knowledge = STROKE_UNKNOWN;
      event = EVENT_OK;
      return;
  }
}

static void finish(knowledge_t known) {
  state = STATE_IDLE;
  knowledge = known;
  event = EVENT_DONE;
}

// The clock stands still until the bridge does what the motion asks for, so that no brake costs stroke.
static void advance(const motion_t* motion) {
  if (motor_direction() == motion->direction) ++clock_ms;
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
  const int8_t direction = (segment.velocity_um_s > 0) - (segment.velocity_um_s < 0);
  const motion_t motion = {direction, segment.counts, segment.velocity_um_s};
  return motion;
}

static motion_t home(void) {
  if (end_stop_ahead(-1)) {
    stroke_nm = LAKE_HOME_UM * 1000L;
    knowledge = STROKE_ESTIMATED;
    begin(STATE_POSITIONING, LAKE_POSITION_MS);
    return kRest;
  }
  if (clock_ms >= end_ms) {
    fault(EVENT_FAULT_HOME);
    return kRest;
  }
  const motion_t motion = {-1, LAKE_HOME_COUNTS, -LAKE_HOME_SPEED_UM_S};
  return motion;
}

static motion_t position(void) {
  if (clock_ms >= end_ms) {
    finish(STROKE_AT_START);
    return kRest;
  }
  const motion_t motion = {1, LAKE_POSITION_COUNTS, LAKE_POSITION_SPEED_UM_S};
  return motion;
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
    event = EVENT_JOG_LIMIT;
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

// The last word before the motor.
static uint8_t is_allowed(const motion_t* motion) {
  if (motion->direction == 0) return 1;
  if (end_stops_pressed() == (END_STOP_RETRACT | END_STOP_EXTEND))
    fault(EVENT_FAULT_BOTH_STOPS);
  else if (end_stop_ahead(motion->direction))
    fault(EVENT_FAULT_STOP);
  else if (state == STATE_RUNNING && soft_limit_ahead(motion->direction))
    fault(EVENT_FAULT_SOFT_LIMIT);
  return state != STATE_FAULT;
}

void controller_init(void) {
  state = STATE_IDLE;
  knowledge = STROKE_UNKNOWN;
}

void controller_tick(void) {
  ++time_ms;
  end_stops_tick();
  take_request();
  motion_t motion = wanted();
  if (!is_allowed(&motion)) motion = kRest;
  motor_tick(motion.direction, motion.counts);
  if (state == STATE_FAULT || state == STATE_IDLE || state == STATE_PAUSED) return;
  advance(&motion);
  if (motor_direction() != 0) stroke_nm += motion.velocity_um_s;
}

void controller_request(request_t what, int16_t jog_counts, uint16_t jog_ms) {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    request = what;
    request_counts = jog_counts;
    request_ms = jog_ms;
  }
}

status_t controller_status(void) {
  status_t now;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    now.time_ms = time_ms;
    now.stroke_um = stroke_um();
    now.counts = motor_counts();
    now.direction = motor_direction();
    now.state = state;
    now.knowledge = knowledge;
    now.end_stops = end_stops_pressed();
  }
  return now;
}

event_t controller_take_event(void) {
  event_t taken;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    taken = event;
    event = EVENT_NONE;
  }
  return taken;
}
