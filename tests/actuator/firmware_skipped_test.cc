// Says so where the tests of simavr/ cannot be built.
#include <gtest/gtest.h>

#ifndef LAKE_AVR_GCC

TEST(Firmware, RunsInSimulator) {
  GTEST_SKIP() << "avr-gcc, libsimavr-dev or libelf-dev is not installed";
}

#endif
