#include "board.h"

#include "chip.h"
#include "config.h"
#include "kept.h"
#include "pins.h"
#include "portable.h"
#include "stm32f4.h"

#define END_STOP_READINGS 4
#define CONVERSIONS 4                      // of each channel in a round
#define ROUND_MOST (CONVERSIONS * 4095UL)  // their sum, each of 12 bits
#define READING_MOST 4092UL                // as of four conversions of 10 bits

// The time of one ms is an UNO's (uno/board.c) but for the converter, whose round of 12 takes 12 x 12 us. All other
// interrupts are served before the tick.
enum { PRIORITY_LOOK, PRIORITY_SERIAL, PRIORITY_CONVERTER, PRIORITY_TICK = 15 };

// A0, A1, A2 are PA0, PA1, PA4, and these inputs of the converter.
#define PIN_A0 14
static const uint8_t kInputs[ANALOG_COUNT] = {0, 1, 4};
static const uint8_t kWired[] = {
    ANALOG_POTENTIOMETER,
#if LAKE_CURRENT_SENSE
    ANALOG_CURRENT,
#endif
#if LAKE_SUPPLY_SENSE
    ANALOG_SUPPLY,
#endif
};

// The independent watchdog's own clock has 17 to 47 kHz: 54 to 150 ms.
#define WATCHDOG_COUNTS 640
#define TICK_CLOCKS (1000 * CHIP_CLOCKS_PER_US)

static volatile uint8_t ticks, is_late;
static uint8_t last_tick;
static volatile uint16_t readings[ANALOG_COUNT];
static uint16_t sum;
static uint8_t wired, conversion;
static volatile uint8_t is_round_over = 1;
static uint32_t reset_flags;

static void begin_conversion(void) {
  ADC1->sqr3 = kInputs[kWired[wired]];
  ADC1->cr2 |= ADC_CR2_SWSTART;
}

void ADC_IRQHandler(void) {
  sum += (uint16_t)ADC1->dr;
  if (++conversion >= CONVERSIONS) {
    readings[kWired[wired]] = (uint16_t)((sum * READING_MOST + ROUND_MOST / 2) / ROUND_MOST);
    sum = 0;
    conversion = 0;
    if (++wired >= sizeof kWired) {
      wired = 0;
      is_round_over = 1;
      return;
    }
  }
  begin_conversion();
}

static void begin_round(void) {
  if (!is_round_over) {
    is_late = 1;
    return;
  }
  is_round_over = 0;
  begin_conversion();
}

void SysTick_Handler(void) {
  begin_round();
  board_tick();
  if (*SCB_ICSR & SCB_ICSR_PENDSTSET) is_late = 1;
  ++ticks;
}

static void init_converter(void) {
  for (uint8_t i = 0; i < sizeof kWired; ++i) pin_mode(PIN_A0 + kWired[i], MODE_ANALOG);
  ADC1->smpr2 = 4UL << 0 | 4UL << 3 | 4UL << 12;  // 84 clocks of 8 MHz for each of the three
  ADC1->cr1 = ADC_CR1_EOCIE;
  ADC1->cr2 = ADC_CR2_ADON;
  chip_wait_us(10);
}

void board_init(void) {
  reset_flags = RCC->csr;
  RCC->csr |= RCC_CSR_RMVF;
  // Normally closed switches to ground with pull-ups, as on an UNO.
  pin_pull_up(LAKE_PIN_RETRACT);
  pin_pull_up(LAKE_PIN_EXTEND);
  pin_mode(LAKE_PIN_RETRACT, MODE_INPUT);
  pin_mode(LAKE_PIN_EXTEND, MODE_INPUT);
#if LAKE_WORN
  pin_pull_up(LAKE_PIN_BUTTON);
  pin_mode(LAKE_PIN_BUTTON, MODE_INPUT);
#endif
#if LAKE_RELAY
  pin_write(LAKE_PIN_RELAY, 0);
  pin_mode(LAKE_PIN_RELAY, MODE_OUTPUT);
#endif
  init_converter();
  kept_init();
}

static void start_watchdog(void) {
  IWDG->kr = IWDG_START;
  IWDG->kr = IWDG_UNLOCK;
  IWDG->pr = 0;  // its clock by 4
  IWDG->rlr = WATCHDOG_COUNTS;
}

void board_start(void) {
  chip_enable(IRQ_TIM3, PRIORITY_LOOK);
  chip_enable(IRQ_TIM4, PRIORITY_LOOK);
  chip_enable(IRQ_USART2, PRIORITY_SERIAL);
  chip_enable(IRQ_ADC, PRIORITY_CONVERTER);
  *SCB_SYSTICK_PRIORITY = PRIORITY_TICK << 4;
  SYSTICK->load = TICK_CLOCKS - 1;
  SYSTICK->val = 0;
  SYSTICK->ctrl = SYSTICK_RUNS;
  start_watchdog();
  chip_allow_interrupts();
}

uint8_t board_wait(void) {
  chip_sleep();
  if (ticks == last_tick) return 0;
  last_tick = ticks;
  IWDG->kr = IWDG_FEED;
  return 1;
}

static uint8_t open_stops(void) {
  uint8_t bits = 0;
  if (pin_read(LAKE_PIN_RETRACT)) bits |= END_STOP_RETRACT;
  if (pin_read(LAKE_PIN_EXTEND)) bits |= END_STOP_EXTEND;
  return bits;
}

uint8_t board_end_stops(void) {
  uint8_t open = open_stops();
  for (uint8_t i = 1; i < END_STOP_READINGS; ++i) {
    chip_wait_us(6);
    open &= open_stops();
  }
  return open;
}

uint8_t board_button(void) {
#if LAKE_WORN
  return !pin_read(LAKE_PIN_BUTTON);
#else
  return 0;
#endif
}

void board_close_relay(uint8_t is_closed) {
#if LAKE_RELAY
  pin_write(LAKE_PIN_RELAY, is_closed);
#else
  (void)is_closed;
#endif
}

uint16_t board_analog(uint8_t which) {
  return readings[which];  // a half word: no interrupt divides it
}

uint8_t board_is_late(void) {
  return is_late;
}

uint8_t board_remembered(uint8_t place) {
  return kept_read(place);
}

void board_remember(uint8_t place, uint8_t number) {
  kept_write(place, number);
}

// A software's reset is the one after an interrupt that nobody expects. Power on sets the flag of a low voltage as
// well.
reset_cause_t board_reset_cause(void) {
  if (reset_flags & (RCC_CSR_IWDG | RCC_CSR_SOFTWARE)) return RESET_BY_WATCHDOG;
  if ((reset_flags & RCC_CSR_BOR) && !(reset_flags & RCC_CSR_POR)) return RESET_BY_LOW_VOLTAGE;
  return RESET_BY_POWER_OR_BUTTON;
}
