// The rig itself: its converter and its receiver do what the data sheet says, seen by a program of the chip's own.
#include <gtest/gtest.h>

#include <cstdlib>

#include "avr_rig.h"
#include "lake/core/atomic_file.h"
#include "temporary_folder.h"

namespace lake {
namespace {

class DatasheetTest : public testing::Test {
 protected:
  // What a program says over the serial line within 50 ms; `body` is its main().
  AvrRig& Run(const std::string& body, double seconds = 0.05) {
    WriteTextFile(folder_ / "probe.c", R"(
#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/delay.h>
static void say(unsigned char c) { while (!(UCSR0A & _BV(UDRE0))) {} UDR0 = c; }
static void number(unsigned long n) { if (n > 9) number(n / 10); say('0' + n % 10); }
static void tell(unsigned long n) { number(n); say(' '); }
static unsigned long convert(void) { unsigned long turns = 0; ADCSRA |= _BV(ADSC); while (ADCSRA & _BV(ADSC)) ++turns; return turns; }
int main(void) {
  UBRR0 = 16; UCSR0A = _BV(U2X0); UCSR0B = _BV(RXEN0) | _BV(TXEN0);
  TCCR1B = _BV(CS10);
)" + body + "\n  say('.'); say('\\n'); for (;;) {} }\n");
    const std::string command = LAKE_AVR_GCC " -mmcu=atmega328p -DF_CPU=16000000UL -std=gnu99 -Os '" +
                                (folder_ / "probe.c").string() + "' -o '" + (folder_ / "probe.elf").string() + "'";
    if (std::system(command.c_str()) != 0) throw std::runtime_error(command);
    actuator_.stroke_mm = 268;  // A0: 1 V
    rig_ = std::make_unique<AvrRig>(folder_ / "probe.elf", actuator_);
    rig_->Run(seconds);
    return *rig_;
  }

  TemporaryFolder folder_;
  Actuator actuator_;
  std::unique_ptr<AvrRig> rig_;
};

// A0 has 1 V, 204 of 1024; A1 2.5 V, 512. The channel that is written 10 us after the start is the next conversion's.
TEST_F(DatasheetTest, AConversionKeepsTheChannelThatItBeganWith) {
  AvrRig& rig = Run(R"(
  _delay_ms(2);
  ADMUX = _BV(REFS0); ADCSRA = _BV(ADEN) | _BV(ADPS2) | _BV(ADPS1); convert(); tell(ADC);
  ADCSRA |= _BV(ADSC); _delay_us(10); ADMUX = _BV(REFS0) | 1; while (ADCSRA & _BV(ADSC)) {} tell(ADC);
  convert(); tell(ADC);
)");
  EXPECT_EQ(rig.Serial(), "204 204 512 .\n");
  EXPECT_EQ(rig.Adc().ChannelChangesWhileBusy(), 1u);
  EXPECT_EQ(rig.Adc().Conversions(), 3u);
}

// 25 and 13 clocks of 64 cycles, and up to one more to the clock's edge.
TEST_F(DatasheetTest, AConversionTakesThirteenClocksTheFirstTwentyFive) {
  AvrRig& rig = Run(R"(
  unsigned times[3];
  ADCSRA = _BV(ADEN) | _BV(ADPS2) | _BV(ADPS1);
  for (unsigned char i = 0; i < 3; ++i) { _delay_us(7); const unsigned from = TCNT1; convert(); times[i] = TCNT1 - from; }
  for (unsigned char i = 0; i < 3; ++i) tell(times[i]);
)");
  int first = 0, second = 0, third = 0;
  ASSERT_EQ(std::sscanf(rig.Serial().c_str(), "%d %d %d .", &first, &second, &third), 3) << rig.Serial();
  constexpr int kPolling = 16;  // cycles of the loop that waits
  for (const auto& [cycles, clocks] : {std::pair{first, 25}, {second, 13}, {third, 13}}) {
    EXPECT_GE(cycles, 64 * clocks);
    EXPECT_LE(cycles, 64 * (clocks + 1) + kPolling);
  }
}

TEST_F(DatasheetTest, AStartWhileAConversionRunsHasNoEffect) {
  AvrRig& rig = Run(R"(
  ADCSRA = _BV(ADEN) | _BV(ADPS2) | _BV(ADPS1);
  ADCSRA |= _BV(ADSC); _delay_us(20); ADCSRA |= _BV(ADSC); _delay_us(300);
)");
  EXPECT_EQ(rig.Adc().StartsWhileBusy(), 1u);
  EXPECT_EQ(rig.Adc().Conversions(), 1u);
}

// Ten bytes back to back take 868 us. Who looks only then finds the first two and, in the shift register, the last.
TEST_F(DatasheetTest, TheReceiverHoldsTwoBytesAndTheShiftRegister) {
  AvrRig& rig =
      Run("  while (!(PIND & 8)) {} _delay_ms(2); while (UCSR0A & _BV(RXC0)) { if (UCSR0A & _BV(DOR0)) say('!'); "
          "say(UDR0); }\n",
          0.001);
  rig.SendPlain("abcdefghij");
  rig.PullWire(false, true);
  rig.Run(0.02);
  EXPECT_EQ(rig.Serial(), "!abj.\n");
  EXPECT_EQ(rig.Receiver().Lost(), 7u);
}

}  // namespace
}  // namespace lake
