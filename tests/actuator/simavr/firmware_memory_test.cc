// Bits of the static memory that flip: nothing starts, and what moves is stopped or goes on as planned. Every bit with
// LAKE_LONG_TESTS=1, else some.
#include <cstdlib>
#include <sstream>

#include "firmware_fixture.h"

namespace lake {
namespace {

class FirmwareMemoryTest : public FirmwareTest {
 protected:
  static constexpr int kFirst = 0x100;  // of the ATmega328P's RAM

  int StaticBytes() {
    const auto file = folder_ / "size";
    EXPECT_EQ(
        std::system(("avr-size '" + elf_.string() + "' | awk 'NR==2 {print $2+$3}' > '" + file.string() + "'").c_str()),
        0);
    return std::atoi(ReadTextFile(file).c_str());
  }

  // Address and size of a static variable; its name may have a suffix of the link-time optimiser.
  std::pair<int, int> PlaceOf(const std::string& name) {
    const auto file = folder_ / "symbols";
    EXPECT_EQ(std::system(("avr-nm -S '" + elf_.string() + "' > '" + file.string() + "'").c_str()), 0);
    std::istringstream symbols(ReadTextFile(file));
    for (std::string address, bytes, kind, symbol; symbols >> address >> bytes >> kind;) {
      if (kind.size() != 1) {  // without a size
        std::getline(symbols, symbol);
        continue;
      }
      symbols >> symbol;
      if ((kind == "b" || kind == "B") && symbol.substr(0, symbol.find('.')) == name)
        return {std::stoi(address, nullptr, 16) & 0xFFFF, std::stoi(bytes, nullptr, 16)};
    }
    ADD_FAILURE() << "no variable " << name;
    return {};
  }

  // Every bit, or one in so many, beginning where the seed says.
  std::vector<int> Bits(int seed) {
    const int bits = 8 * StaticBytes(), step = std::getenv("LAKE_LONG_TESTS") ? 1 : bits / 20;
    std::vector<int> some;
    for (int bit = seed * 7 % step; bit < bits; bit += step) some.push_back(bit);
    return some;
  }
};

TEST_F(FirmwareMemoryTest, ABitThatFlipsAtRestStartsNothing) {
  Build(FreeDesign(kKnots), "");
  for (const int bit : Bits(1)) {
    PowerUp();
    rig_->Run(0.03);
    rig_->FlipBit(kFirst + bit / 8, bit % 8);
    rig_->Run(0.08);
    for (const RigSample& sample : rig_->Samples()) ASSERT_EQ(sample.duty, 0) << "bit " << bit;
  }
}

// Of the state all but its last byte, which whoever tells the news takes.
TEST_F(FirmwareMemoryTest, EachByteThatNothingButTheControllerChangesIsKept) {
  Build(FreeDesign(kKnots), "");
  int bit = 0;
  for (const char* name : {"machine", "m", "jog", "q", "behind"}) {
    const auto [address, bytes] = PlaceOf(name);
    ASSERT_GT(bytes, 8) << name;
    for (int byte = 0; byte < bytes - (address == PlaceOf("machine").first ? 1 : 0); ++byte, bit = (bit + 3) % 8) {
      PowerUp();
      rig_->Run(0.03);
      rig_->FlipBit(address + byte, bit);
      EXPECT_TRUE(rig_->RunUntil("ALARM:17\n", 0.05)) << "byte " << byte << " of " << name << ", bit " << bit;
    }
  }
}

// It stops, or goes on as planned, and obeys a hold; a hang ends by the watchdog after 0.12 s.
TEST_F(FirmwareMemoryTest, ABitThatFlipsInARunDoesNotRunAway) {
  Build(FreeDesign({{0, 300}, {3, 310}}), "");
  for (const int bit : Bits(3)) {
    PowerUp();
    Start();
    rig_->Run(0.1);
    const double from = rig_->Stroke();
    rig_->FlipBit(kFirst + bit / 8, bit % 8);
    rig_->Run(0.03);
    rig_->SendNow('!');
    rig_->Run(0.2);
    EXPECT_EQ(rig_->Samples().back().duty, 0) << "bit " << bit << "\n" << rig_->Serial();
    // 3.3 mm/s for 0.03 s and the run-down; a hang at full speed would be 1.2 mm.
    EXPECT_LT(std::abs(rig_->Stroke() - from), 1.3) << "bit " << bit;
  }
}

}  // namespace
}  // namespace lake
