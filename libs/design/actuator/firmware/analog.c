#include "analog.h"

#include "board.h"
#include "config.h"
#include "divide.h"
#include "portable.h"

// How long something must be wrong, and how long nothing is said after a reset.
#define WRONG_MS 20
#define QUIET_MS 50
#define WIPER_WRONG_MS 10
#define SHORT_MS 5
#define STALL_MS 300
#define NO_CURRENT_MS 300
#define NEAR_MS 100     // in open loop, whose speeds the voltage sets
#define AT_REST_MS 300  // after which a motor takes no current
#define STRAY_MS 20
#define STRAY_MA 250
#define ZERO_READINGS 82  // by which the sensor's zero may be off: 0.1 V
#define ZERO_SMOOTHING 8
// From one filtered reading to the next no actuator goes 3 mm.
#define WIPER_JUMP (3000000L / (LAKE_POT_NM_PER_COUNT < 0 ? -LAKE_POT_NM_PER_COUNT : LAKE_POT_NM_PER_COUNT))

// A reading is the sum of four conversions. Of the last three the middle one counts, so a single wild one does not; a
// first-order filter of 2^SMOOTHING ms follows.
#define SMOOTHING 3

typedef struct {
  uint16_t last[2];
  uint16_t smooth;  // << SMOOTHING
  uint16_t middle;
} filter_t;

static filter_t filters[ANALOG_COUNT];
static volatile uint8_t quiet_ms;
static uint8_t faults;

static uint16_t middle_of(uint16_t a, uint16_t b, uint16_t c) {
  const uint16_t low = a < b ? a : b;
  const uint16_t high = a < b ? b : a;
  return c < low ? low : c > high ? high : c;
}

static void read_channel(uint8_t channel) {
  filter_t* f = &filters[channel];
  const uint16_t now = board_analog(channel);
  f->middle = middle_of(f->last[0], f->last[1], now);
  f->last[0] = f->last[1];
  f->last[1] = now;
}

static void settle(filter_t* f) {
  f->smooth = (uint16_t)(f->middle << SMOOTHING);
}

static void smooth(filter_t* f) {
  f->smooth += f->middle - (f->smooth >> SMOOTHING);
}

static void set_fault(uint8_t bit, uint8_t is_wrong) {
  faults = (uint8_t)(is_wrong ? faults | bit : faults & ~bit);
}

// Sets the bit once something has been wrong for so long, takes it back when it is right.
static void judge(uint8_t bit, uint8_t wrong, uint16_t* wrong_ms, uint16_t most_ms) {
  if (!wrong)
    *wrong_ms = 0;
  else if (*wrong_ms < most_ms)
    ++*wrong_ms;
  set_fault(bit, *wrong_ms >= most_ms);
}

static uint8_t is_supply_expected;

void analog_expect_supply(uint8_t is_on) {
  is_supply_expected = is_on;
}

uint8_t analog_has_supply(void) {
  return LAKE_SUPPLY_SENSE && filters[ANALOG_SUPPLY].middle > LAKE_SUPPLY_LEAST / 3;
}

static void watch_supply(void) {
  static uint16_t wrong_ms, far_ms;
  const uint16_t now = filters[ANALOG_SUPPLY].middle;
  const uint8_t is_off = now < LAKE_SUPPLY_LEAST || now > LAKE_SUPPLY_MOST;
  judge(ANALOG_NO_SUPPLY, is_supply_expected && is_off, &wrong_ms, WRONG_MS);
  if (LAKE_FEEDBACK || faults & ANALOG_NO_SUPPLY) return;
  const uint8_t is_far = now < LAKE_SUPPLY_NEAR_LEAST || now > LAKE_SUPPLY_NEAR_MOST;
  judge(ANALOG_NO_SUPPLY, is_supply_expected && is_far, &far_ms, NEAR_MS);
}

// How much more duty it takes than at the nominal supply, in parts of 2^31. Moved by what it is wrong by, it comes to
// nominal / reading without a division, with a time constant of 2^16 / reading ms: 33 at 12 V, 98 at 4 V.
#define WEIGHS_SUPPLY (LAKE_SUPPLY_SENSE && LAKE_FEEDBACK)
#define NOMINAL_DUTY ((uint32_t)1 << 31)
static uint32_t more;

static uint16_t more_15(void) {  // parts of 2^15
  return (uint16_t)(more >> 16);
}

static void weigh_supply(void) {
  const uint16_t now = filters[ANALOG_SUPPLY].middle;
  if (now < LAKE_SUPPLY_LEAST || now > LAKE_SUPPLY_MOST) return;  // off, or behind a relay that is open
  more += ((uint32_t)LAKE_SUPPLY_NOMINAL << 15) - (uint32_t)more_15() * now;
}

uint16_t analog_at_supply(uint16_t counts) {
  if (!WEIGHS_SUPPLY) return counts;
  const uint16_t all = (uint16_t)(((uint32_t)(uint16_t)(2 * counts) * more_15()) >> 16);
  return all > LAKE_PWM_PERIOD ? LAKE_PWM_PERIOD : all;
}
// Worked out once per ms: a division takes the chip 40 us.
static int32_t stroke_um;
static int32_t slow;  // the same, um << SLOW

int32_t analog_stroke_um(void) {
  return stroke_um;
}

int32_t analog_slow_um(void) {
  return slow >> SLOW;
}

static void tell_stroke(void) {
  // Whole readings and the rest apart, so that 32 bits suffice.
  const uint16_t smooth = filters[ANALOG_POTENTIOMETER].smooth;
  const int32_t rest_nm = ((int32_t)(smooth & ((1 << SMOOTHING) - 1)) * LAKE_POT_NM_PER_COUNT) >> SMOOTHING;
  stroke_um = thousandth(LAKE_POT_ZERO_NM + (int32_t)(smooth >> SMOOTHING) * LAKE_POT_NM_PER_COUNT + rest_nm);
}

// A reading that no actuator can have come to is not taken. If it stays, the wiper is lost.
static void watch_wiper(void) {
  static uint16_t wrong_ms;
  filter_t* f = &filters[ANALOG_POTENTIOMETER];
  const int16_t jump = (int16_t)f->middle - (int16_t)(f->smooth >> SMOOTHING);
  const uint8_t jumps = jump > WIPER_JUMP || jump < -WIPER_JUMP;
  judge(ANALOG_NO_WIPER, jumps || f->middle < LAKE_POT_LEAST || f->middle > LAKE_POT_MOST, &wrong_ms, WIPER_WRONG_MS);
  if (!jumps)
    smooth(f);
  else if (faults & ANALOG_NO_WIPER)
    settle(f);
  tell_stroke();
  slow += stroke_um - (slow >> SLOW);
}

static int16_t current_ma;
static uint32_t zero;  // what the sensor reads at rest, << ZERO_SMOOTHING
static uint16_t rest_ms, driven_ms, none_ms;
static uint8_t had_inrush;

// From so many readings on beside the zero it is more than LAKE_CURRENT_MOST_MA.
#define SHORT_READINGS \
  ((int16_t)(((LAKE_CURRENT_MOST_MA + 1L) * 1000 + LAKE_CURRENT_UA_PER_COUNT - 1) / LAKE_CURRENT_UA_PER_COUNT))
static volatile uint16_t zero_now;
static volatile uint8_t was_short;  // since the main loop looked

uint8_t analog_interrupt(void) {
  static uint8_t short_ms;
  if (!LAKE_CURRENT_SENSE || quiet_ms > 0) return 0;
  filter_t* f = &filters[ANALOG_CURRENT];
  read_channel(ANALOG_CURRENT);
  smooth(f);
  const int16_t from_zero = (int16_t)((f->smooth >> SMOOTHING) - zero_now);
  if (from_zero < SHORT_READINGS && from_zero > -SHORT_READINGS)
    short_ms = 0;
  else if (short_ms < SHORT_MS)
    ++short_ms;
  if (short_ms < SHORT_MS) return 0;
  was_short = 1;
  return 1;
}

int16_t analog_current_ma(void) {
  return current_ma;
}

uint8_t analog_is_without_current(void) {
  return none_ms >= NO_CURRENT_MS;
}

static uint8_t is_near_zero(uint16_t reading) {
  return reading + ZERO_READINGS > LAKE_CURRENT_ZERO && reading < LAKE_CURRENT_ZERO + ZERO_READINGS;
}

static void set_zero(uint32_t reading) {  // << ZERO_SMOOTHING
  zero = reading;
  ATOMICALLY {
    zero_now = (uint16_t)(reading >> ZERO_SMOOTHING);
  }
}

// A lost wire or a current that flows is not learnt.
static void learn_zero(uint16_t reading) {
  if (is_near_zero(reading)) set_zero(zero + reading - (zero >> ZERO_SMOOTHING));
}

static uint16_t counted(uint16_t ms, uint8_t goes_on) {
  return !goes_on ? 0 : ms < 0xFFFF ? ms + 1 : ms;
}

static void watch_current(uint16_t counts) {
  static uint16_t stall_ms, stray_ms;
  uint16_t reading = 0;
  ATOMICALLY {
    reading = filters[ANALOG_CURRENT].smooth >> SMOOTHING;
  }
  const int16_t from_zero = (int16_t)(reading - (uint16_t)(zero >> ZERO_SMOOTHING));
  current_ma = (int16_t)thousandth(from_zero * (int32_t)LAKE_CURRENT_UA_PER_COUNT);
  const int16_t ma = current_ma < 0 ? -current_ma : current_ma;
  rest_ms = counted(rest_ms, counts == 0);
  driven_ms = counted(driven_ms, counts > 0);
  none_ms = counted(none_ms, counts > 0 && ma < LAKE_CURRENT_LEAST_MA);
  had_inrush = counts > 0 && (had_inrush || ma >= LAKE_CURRENT_LEAST_MA);
  const uint8_t is_at_rest = rest_ms >= AT_REST_MS;
  if (is_at_rest && ma < STRAY_MA) learn_zero(reading);
  set_fault(ANALOG_OVERCURRENT, was_short);
  was_short = 0;
  judge(ANALOG_STALL_CURRENT, ma > LAKE_CURRENT_STALL_MA, &stall_ms, STALL_MS);
  judge(ANALOG_STRAY_CURRENT, is_at_rest && ma > STRAY_MA, &stray_ms, STRAY_MS);
  // A load that helps may leave a motor without current, but not one that is being started.
  set_fault(ANALOG_NO_INRUSH, driven_ms >= NO_CURRENT_MS && !had_inrush);
}

void analog_init(void) {
  quiet_ms = QUIET_MS;
  faults = 0;
  is_supply_expected = 1;
  more = NOMINAL_DUTY;
}

// After a reset the filters begin with what they read.
static void begin(void) {
  read_channel(ANALOG_CURRENT);
  for (uint8_t channel = 0; channel < ANALOG_COUNT; ++channel) settle(&filters[channel]);
  if (LAKE_FEEDBACK) {
    tell_stroke();
    slow = stroke_um * ((int32_t)1 << SLOW);
  }
  if (LAKE_CURRENT_SENSE) {
    const uint16_t reading = filters[ANALOG_CURRENT].middle;
    set_zero((uint32_t)(is_near_zero(reading) ? reading : LAKE_CURRENT_ZERO) << ZERO_SMOOTHING);
  }
  quiet_ms = (uint8_t)(quiet_ms - 1);
}

void analog_tick(uint16_t counts) {
  read_channel(ANALOG_POTENTIOMETER);
  read_channel(ANALOG_SUPPLY);
  if (quiet_ms > 0) {
    begin();
    return;
  }
  if (LAKE_SUPPLY_SENSE) watch_supply();
  if (WEIGHS_SUPPLY) weigh_supply();
  if (LAKE_FEEDBACK) watch_wiper();
  if (LAKE_CURRENT_SENSE) watch_current(counts);
}

uint8_t analog_faults(void) {
  return faults;
}
