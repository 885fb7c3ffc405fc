#include "chip.h"

#include "stm32f4.h"

// 8 MHz / 8 * 256 / 8 / 2 = 16 MHz. All three chips allow it: F401's multiplier begins at 192.
#define PLL_DIVIDER 8UL
#define PLL_MULTIPLIER (256UL << 6)
#define PLL_BY_8 (3UL << 16)
#define PLL_USB_BY_8 (8UL << 24)

static void start_clock(void) {
  RCC->cr |= RCC_CR_HSEBYP;
  RCC->cr |= RCC_CR_HSEON;
  while (!(RCC->cr & RCC_CR_HSERDY)) {
  }
  RCC->pllcfgr =
      (RCC->pllcfgr & RCC_PLLCFGR_RESERVED) | RCC_PLLCFGR_HSE | PLL_DIVIDER | PLL_MULTIPLIER | PLL_BY_8 | PLL_USB_BY_8;
  RCC->cr |= RCC_CR_PLLON;
  while (!(RCC->cr & RCC_CR_PLLRDY)) {
  }
  RCC->cfgr |= RCC_CFGR_HPRE_2;  // before the PLL's 32 MHz, for which the flash would need a wait state
  RCC->cfgr |= RCC_CFGR_SW_PLL;
  while ((RCC->cfgr & RCC_CFGR_SWS) != RCC_CFGR_SWS_PLL) {
  }
  RCC->cr |= RCC_CR_CSSON;
}

void chip_init(void) {
  start_clock();
  RCC->ahb1enr |= 7;  // the ports A, B and C
  RCC->apb1enr |= RCC_APB1_TIM3 | RCC_APB1_TIM4 | RCC_APB1_USART2;
  RCC->apb2enr |= RCC_APB2_ADC1;
  *CORE_DEMCR |= CORE_DEMCR_TRCENA;
  DWT->ctrl |= 1;
}

void chip_wait_us(uint8_t us) {
  const uint32_t since = DWT->cyccnt;
  while (DWT->cyccnt - since < (uint32_t)us * CHIP_CLOCKS_PER_US) {
  }
}

void chip_enable(uint8_t interrupt, uint8_t priority) {
  NVIC_PRIORITY[interrupt] = (uint8_t)(priority << 4);
  NVIC_ENABLE[interrupt / 32] = BIT(interrupt % 32);
}
