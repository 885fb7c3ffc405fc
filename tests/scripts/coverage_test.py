"""Which lines were run, of a program whose worker process ends by _exit()."""
import subprocess
import unittest

from project import Project

SOURCE = """#include <sys/wait.h>
#include <unistd.h>
int InTheWorker() { return 7; }
int Never() {
  return 8;
}
int main() {
  if (fork() == 0) _exit(InTheWorker());
  wait(nullptr);
}
"""


class Coverage(Project):
    def setUp(self):
        super().setUp()
        self.copy("scripts/coverage.py", "tests/coverage")
        self.write("libs/base/room/src/room.cc", SOURCE)
        (self.folder / "build/libs").mkdir(parents=True)

    def compile(self, *words):
        subprocess.run(["c++", "--coverage", *words], cwd=self.folder, check=True)

    def test_worker_processes_count(self):
        self.compile("-c", "libs/base/room/src/room.cc", "-o", "build/libs/room.o")
        self.compile("-Wl,--wrap=_exit", "build/libs/room.o", "tests/coverage/keep_counts.cc", "-o", "program")
        subprocess.run(["./program"], cwd=self.folder, check=True)
        code, said = self.run_script("scripts/coverage.py", "build", "--least", "50")
        self.assertEqual(code, 0, said)
        self.assertRegex(said, r"\| base/room \| 7 \| 71\.4 % \|")
        self.assertEqual((self.folder / "build/missed.txt").read_text(), "libs/base/room/src/room.cc:4-5\n")
        self.assertEqual(self.run_script("scripts/coverage.py", "build", "--least", "90")[0], 1)

    def test_a_build_without_counts_says_so(self):
        code, said = self.run_script("scripts/coverage.py", "build")
        self.assertEqual(code, 1)
        self.assertIn("scripts/coverage.sh", said)


if __name__ == "__main__":
    unittest.main()
