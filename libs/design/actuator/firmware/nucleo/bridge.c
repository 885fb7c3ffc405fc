#include "bridge.h"

#include "chip.h"
#include "config.h"
#include "pins.h"
#include "stm32f4.h"

// D9 has the PWM of timer 3, channel 2, D10 that of timer 4, channel 1: alternate function 2 of either pin. A channel
// is high as long as the timer's count is below its compare value: one of LAKE_PWM_PERIOD is high all the time.
#define PWM_FUNCTION 2
#define MODE_PWM_PRELOADED 0x68UL
#define SETTLE_US 10  // the pin's capacitance, the bridge's rise

static volatile int8_t direction_now;
static uint8_t is_driving;

static tim_t* timer_of(uint8_t pin) {
  return pin == 9 ? TIM3 : TIM4;
}

static uint8_t channel_of(uint8_t pin) {  // from 0 on
  return pin == 9 ? 1 : 0;
}

// ENA (L298N), or the input that drives (BTS7960, whose outputs follow their inputs while ENA is high).
static uint8_t pwm_pin(void) {
#if LAKE_BRIDGE_BTS7960
  return direction_now > 0 ? LAKE_PIN_IN1 : LAKE_PIN_IN2;
#else
  return LAKE_PIN_ENA;
#endif
}

#if LAKE_BRIDGE_SENSE

// As on an UNO (uno/bridge.c), where the reasons stand: a period is looked at at the PWM's rise and at its fall.
#define RISE_US 8
#define FALL_US 4
#define LOW_CLOCKS 160
#define LATE_CLOCKS 320

static volatile uint8_t contradicts, contradicts_high;  // of the last looks that could tell

static uint8_t driven_is_high(void) {
  return pin_read(direction_now > 0 ? LAKE_PIN_OUT1 : LAKE_PIN_OUT2);
}
static uint8_t other_is_high(void) {
  return pin_read(direction_now > 0 ? LAKE_PIN_OUT2 : LAKE_PIN_OUT1);
}

static void look_at_rise(tim_t* timer, uint8_t channel) {
  chip_wait_us(RISE_US);
  const uint8_t is_wrong = !driven_is_high() || other_is_high();
  if (timer->cnt < timer->ccr[channel]) contradicts_high = is_wrong;
  timer->sr = ~BIT(channel + 1);
  timer->dier = BIT(channel + 1);
}

static void look_at_fall(tim_t* timer, uint8_t channel) {
  timer->dier = 0;
  chip_wait_us(FALL_US);
  const uint8_t is_high = driven_is_high();
  const uint16_t fall = (uint16_t)timer->ccr[channel];
  if (contradicts_high || fall > LAKE_PWM_PERIOD - LOW_CLOCKS)
    contradicts = contradicts_high;
  else if ((uint16_t)(timer->cnt - fall) < LATE_CLOCKS)
    contradicts = is_high;
}

static void look(tim_t* timer) {
  const uint8_t channel = channel_of(timer == TIM3 ? 9 : 10);
  if (timer->dier & TIM_UPDATE)
    look_at_rise(timer, channel);
  else
    look_at_fall(timer, channel);
}

void TIM3_IRQHandler(void) {
  look(TIM3);
}
void TIM4_IRQHandler(void) {
  look(TIM4);
}

static void stop_looking(void) {
  TIM3->dier = TIM4->dier = 0;
  contradicts = contradicts_high = 0;
}

uint8_t bridge_outputs_contradict(void) {
  const uint8_t last = contradicts;
  tim_t* const timer = timer_of(pwm_pin());
  timer->sr = ~TIM_UPDATE;
  timer->dier = TIM_UPDATE;
  return last;
}

#else

static void stop_looking(void) {}

uint8_t bridge_outputs_contradict(void) {
  return 0;
}

#endif

static void begin_low(uint8_t pin) {
  pin_write(pin, 0);
  pin_mode(pin, MODE_OUTPUT);
}

static void init_pwm(uint8_t pin) {
  tim_t* const timer = timer_of(pin);
  const uint8_t channel = channel_of(pin);
  pin_alternate(pin, PWM_FUNCTION);
  timer->cr1 = TIM_CR1_ARPE | TIM_CR1_URS;
  timer->arr = LAKE_PWM_PERIOD - 1;
  timer->ccmr1 = MODE_PWM_PRELOADED << (8 * channel);
  timer->ccer = BIT(4 * channel);
  timer->egr = TIM_UPDATE;
  timer->cr1 |= TIM_CR1_CEN;
}

void bridge_init(void) {
  begin_low(LAKE_PIN_ENA);
  begin_low(LAKE_PIN_IN1);
  begin_low(LAKE_PIN_IN2);
#if LAKE_BRIDGE_BTS7960
  init_pwm(LAKE_PIN_IN1);
  init_pwm(LAKE_PIN_IN2);
#else
  init_pwm(LAKE_PIN_ENA);
#endif
}

static void set_low(uint8_t pin) {
  pin_write(pin, 0);
  pin_disconnect(pin);
}

void bridge_off(void) {
  stop_looking();
  is_driving = 0;
  set_low(LAKE_PIN_ENA);
  set_low(LAKE_PIN_IN1);
  set_low(LAKE_PIN_IN2);
}

void bridge_brake(void) {
  pin_write(LAKE_PIN_ENA, 1);
  chip_wait_us(SETTLE_US);
}

void bridge_direct(int8_t direction) {
  direction_now = direction;
  pin_write(LAKE_PIN_IN1, direction > 0);
  pin_write(LAKE_PIN_IN2, direction < 0);
}

void bridge_drive(uint16_t counts) {
  const uint8_t pin = pwm_pin();
  tim_t* const timer = timer_of(pin);
  timer->ccr[channel_of(pin)] = counts;
  if (!is_driving) timer->egr = TIM_UPDATE;  // else from the next period on
  is_driving = 1;
  pin_mode(pin, MODE_ALTERNATE);
#if LAKE_BRIDGE_BTS7960
  pin_write(LAKE_PIN_ENA, 1);
#endif
}

uint8_t bridge_enable_is_free(void) {
  pin_mode(LAKE_PIN_ENA, MODE_INPUT);
  chip_wait_us(SETTLE_US);
  const uint8_t is_high = pin_read(LAKE_PIN_ENA);
  if (!is_high) pin_mode(LAKE_PIN_ENA, MODE_OUTPUT);  // against what holds it high it stays an input
  return !is_high;
}

uint8_t bridge_outputs_are_low(void) {
#if LAKE_BRIDGE_SENSE
  return !pin_read(LAKE_PIN_OUT1) && !pin_read(LAKE_PIN_OUT2);
#else
  return 0;
#endif
}
