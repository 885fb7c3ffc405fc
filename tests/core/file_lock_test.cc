// One process at a time, by a lock on a file.
#include "lake/core/file_lock.h"

#include <gmock/gmock.h>

#include <atomic>
#include <future>
#include <optional>

#include "lake/core/error.h"
#include "temporary_folder.h"

namespace lake {
namespace {

TEST(FileLock, IsHadByOneAtATime) {
  const TemporaryFolder folder;
  const auto path = folder.Path() / "lock";
  std::optional<FileLock> first(std::in_place, path, [] { ADD_FAILURE() << "nobody has it yet"; });
  std::promise<void> waits;
  std::atomic<bool> is_free = false;
  const auto second = std::async(std::launch::async, [&] {
    const FileLock lock(path, [&] { waits.set_value(); });  // a second call would throw
    EXPECT_TRUE(is_free);
  });
  waits.get_future().wait();
  is_free = true;
  first.reset();
  second.wait();
}

TEST(FileLock, WhatCannotBeMadeIsAnError) {
  const TemporaryFolder folder;
  const auto path = folder.Path() / "no folder" / "lock";
  EXPECT_THAT([&] { FileLock{path}; }, testing::ThrowsMessage<Error>(testing::HasSubstr(path.string())));
}

}  // namespace
}  // namespace lake
