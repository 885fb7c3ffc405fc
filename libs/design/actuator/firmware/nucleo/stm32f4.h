// The registers that the firmware uses of an STM32F401, F411 or F446, which are alike in these: reference manuals
// RM0368, RM0383 and RM0390, and for the core's own PM0214. A test on a PC puts memory of its own in their place.
#ifndef LAKE_STM32F4_H
#define LAKE_STM32F4_H

#include <stdint.h>

#ifndef REGISTERS_AT
#define REGISTERS_AT(address) (address)
#endif

#define BIT(number) ((uint32_t)1 << (number))

typedef volatile uint32_t reg_t;

typedef struct {
  reg_t mode, output_type, speed, pull, input, output, set_reset, lock, alternate[2];
} gpio_t;
#define GPIOA ((gpio_t*)REGISTERS_AT(0x40020000))
#define GPIOB ((gpio_t*)REGISTERS_AT(0x40020400))
#define GPIOC ((gpio_t*)REGISTERS_AT(0x40020800))
enum { MODE_INPUT = 0, MODE_OUTPUT = 1, MODE_ALTERNATE = 2, MODE_ANALOG = 3 };

typedef struct {
  reg_t cr, pllcfgr, cfgr, cir, reset[8], ahb1enr, ahb2enr, ahb3enr, reserved1, apb1enr, apb2enr, reserved2[10], bdcr,
      csr;
} rcc_t;
#define RCC ((rcc_t*)REGISTERS_AT(0x40023800))
#define RCC_CR_HSEON BIT(16)
#define RCC_CR_HSERDY BIT(17)
#define RCC_CR_HSEBYP BIT(18)
#define RCC_CR_CSSON BIT(19)
#define RCC_CR_PLLON BIT(24)
#define RCC_CR_PLLRDY BIT(25)
#define RCC_PLLCFGR_RESERVED 0xF0000000UL
#define RCC_PLLCFGR_HSE BIT(22)
#define RCC_CFGR_SW_PLL 2UL
#define RCC_CFGR_SWS (3UL << 2)
#define RCC_CFGR_SWS_PLL (2UL << 2)
#define RCC_CFGR_HPRE_2 (8UL << 4)
#define RCC_APB1_TIM3 BIT(1)
#define RCC_APB1_TIM4 BIT(2)
#define RCC_APB1_USART2 BIT(17)
#define RCC_APB2_ADC1 BIT(8)
#define RCC_CSR_RMVF BIT(24)
#define RCC_CSR_BOR BIT(25)
#define RCC_CSR_POR BIT(27)
#define RCC_CSR_SOFTWARE BIT(28)
#define RCC_CSR_IWDG BIT(29)

typedef struct {
  reg_t cr1, cr2, smcr, dier, sr, egr, ccmr1, ccmr2, ccer, cnt, psc, arr, rcr, ccr[4];
} tim_t;
#define TIM3 ((tim_t*)REGISTERS_AT(0x40000400))
#define TIM4 ((tim_t*)REGISTERS_AT(0x40000800))
#define TIM_CR1_CEN BIT(0)
#define TIM_CR1_URS BIT(2)
#define TIM_CR1_ARPE BIT(7)
#define TIM_UPDATE BIT(0)

typedef struct {
  reg_t sr, dr, brr, cr1, cr2, cr3;
} usart_t;
#define USART2 ((usart_t*)REGISTERS_AT(0x40004400))
#define USART_SR_FE BIT(1)
#define USART_SR_NE BIT(2)
#define USART_SR_ORE BIT(3)
#define USART_SR_RXNE BIT(5)
#define USART_SR_TXE BIT(7)
#define USART_CR1_RE BIT(2)
#define USART_CR1_TE BIT(3)
#define USART_CR1_RXNEIE BIT(5)
#define USART_CR1_TXEIE BIT(7)
#define USART_CR1_UE BIT(13)

typedef struct {
  reg_t sr, cr1, cr2, smpr1, smpr2, jofr[4], htr, ltr, sqr1, sqr2, sqr3, jsqr, jdr[4], dr;
} adc_t;
#define ADC1 ((adc_t*)REGISTERS_AT(0x40012000))
#define ADC_SR_EOC BIT(1)
#define ADC_CR1_EOCIE BIT(5)
#define ADC_CR2_ADON BIT(0)
#define ADC_CR2_SWSTART BIT(30)

typedef struct {
  reg_t kr, pr, rlr, sr;
} iwdg_t;
#define IWDG ((iwdg_t*)REGISTERS_AT(0x40003000))
#define IWDG_UNLOCK 0x5555
#define IWDG_FEED 0xAAAA
#define IWDG_START 0xCCCC

typedef struct {
  reg_t acr, keyr, optkeyr, sr, cr;
} flash_t;
#define FLASH ((flash_t*)REGISTERS_AT(0x40023C00))
#define FLASH_KEY1 0x45670123UL
#define FLASH_KEY2 0xCDEF89ABUL
#define FLASH_SR_BSY BIT(16)
#define FLASH_CR_PG BIT(0)
#define FLASH_CR_SER BIT(1)
#define FLASH_CR_SECTOR(number) ((uint32_t)(number) << 3)
#define FLASH_CR_HALFWORDS BIT(8)
#define FLASH_CR_WORDS BIT(9)
#define FLASH_CR_STRT BIT(16)
#define FLASH_CR_LOCK BIT(31)

typedef struct {
  reg_t ctrl, load, val;
} systick_t;
#define SYSTICK ((systick_t*)REGISTERS_AT(0xE000E010))
#define SYSTICK_RUNS 7UL  // from the core's clock, with its interrupt

// The core's interrupts: enables from number 0 on, a byte of priority each, of which the upper four bits count.
#define NVIC_ENABLE ((reg_t*)REGISTERS_AT(0xE000E100))
#define NVIC_PRIORITY ((volatile uint8_t*)REGISTERS_AT(0xE000E400))
#define SCB_ICSR ((reg_t*)REGISTERS_AT(0xE000ED04))
#define SCB_ICSR_PENDSTSET BIT(26)
#define SCB_AIRCR ((reg_t*)REGISTERS_AT(0xE000ED0C))
#define SCB_AIRCR_RESET 0x05FA0004UL
#define SCB_SYSTICK_PRIORITY ((volatile uint8_t*)REGISTERS_AT(0xE000ED23))
enum { IRQ_ADC = 18, IRQ_TIM3 = 29, IRQ_TIM4 = 30, IRQ_USART2 = 38 };

#define CORE_DEMCR ((reg_t*)REGISTERS_AT(0xE000EDFC))
#define CORE_DEMCR_TRCENA BIT(24)
typedef struct {
  reg_t ctrl, cyccnt;
} dwt_t;
#define DWT ((dwt_t*)REGISTERS_AT(0xE0001000))

#endif
