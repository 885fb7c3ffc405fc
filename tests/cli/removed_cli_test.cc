// What earlier versions had: one line says so, and what to use instead.
#include <gmock/gmock.h>

#include "cli/program_run.h"
#include "lake/core/removed.h"

namespace lake {
namespace {

using testing::HasSubstr;

TEST(RemovedOptions, EachIsRefusedWithWhatToUseInstead) {
  const TemporaryFolder folder;
  for (const Removed& removed : AllRemoved()) {
    const bool is_choice = removed.name == "sdf";  // by its place
    const Outcome outcome =
        Shell(folder, fmt::format("{} {}{}", removed.program, is_choice ? "design.yaml " : "", removed.name));
    EXPECT_EQ(outcome.exit_code, 2) << removed.name;
    EXPECT_EQ(outcome.err, fmt::format("{}: {} is removed: {}\n", removed.program, removed.name, removed.instead));
    EXPECT_FALSE(std::filesystem::exists(folder / "lake-out"));
  }
}

}  // namespace
}  // namespace lake
