// What every test program begins with.
#include <gmock/gmock.h>
#include <malloc.h>

int main(int argc, char** argv) {
  // A rendered scene makes pictures of many MB for every frame. Given back to the system and asked for again each time,
  // their pages are a tenth of the time that the tests on recordings take.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  // On Debian 13 a library that OpenCV brings starts a thread of its own, and a process with threads must not fork.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
