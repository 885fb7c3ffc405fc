// From a reset to main: the vectors, the variables. Interrupts are blocked until board_start.
#include "bridge.h"
#include "chip.h"
#include "stm32f4.h"

extern uint32_t stack_top, data_from, data_begin, data_end, bss_begin, bss_end;  // nucleo.ld
int main(void);

void ADC_IRQHandler(void);
void TIM3_IRQHandler(void);
void TIM4_IRQHandler(void);
void USART2_IRQHandler(void);
void SysTick_Handler(void);

// A fault of the core, a lost crystal (the NMI), an interrupt that nobody has asked for: the motor is off, then a
// reset.
static void unexpected(void) {
  bridge_off();
  *SCB_AIRCR = SCB_AIRCR_RESET;
  for (;;) {
  }
}

// Timers look only with LAKE_BRIDGE_SENSE.
void TIM3_IRQHandler(void) __attribute__((weak, alias("unexpected")));
void TIM4_IRQHandler(void) __attribute__((weak, alias("unexpected")));

void start(void);
void start(void) {
  __asm volatile("cpsid i");
  for (uint32_t *from = &data_from, *to = &data_begin; to < &data_end;) *to++ = *from++;
  for (uint32_t* to = &bss_begin; to < &bss_end;) *to++ = 0;
  chip_init();
  main();
  unexpected();
}

#define IRQ_COUNT 97
#define CORE_HANDLERS 15  // and then the interrupts, from number 0 on
#define AT_IRQ(number) (CORE_HANDLERS + (number))

typedef void (*handler_t)(void);
__attribute__((section(".vectors"), used)) static const struct {
  uint32_t* stack;
  handler_t handlers[AT_IRQ(IRQ_COUNT)];
} kVectors = {&stack_top,
              {[0] = start,
               [1 ... 13] = unexpected,
               [14] = SysTick_Handler,
               [AT_IRQ(0)... AT_IRQ(IRQ_ADC - 1)] = unexpected,
               [AT_IRQ(IRQ_ADC)] = ADC_IRQHandler,
               [AT_IRQ(IRQ_ADC + 1)... AT_IRQ(IRQ_TIM3 - 1)] = unexpected,
               [AT_IRQ(IRQ_TIM3)] = TIM3_IRQHandler,
               [AT_IRQ(IRQ_TIM4)] = TIM4_IRQHandler,
               [AT_IRQ(IRQ_TIM4 + 1)... AT_IRQ(IRQ_USART2 - 1)] = unexpected,
               [AT_IRQ(IRQ_USART2)] = USART2_IRQHandler,
               [AT_IRQ(IRQ_USART2 + 1)... AT_IRQ(IRQ_COUNT - 1)] = unexpected}};
