"""What CI runs: each stage whatever became of those before, and ctest's closing lines at the end."""
import unittest

from project import Project

TEST = """#!/bin/sh
folder=build/test
[ "$1" != --asan-readers ] || folder=build/asan
mkdir -p $folder
printf '1/1 Test #1: A.B ... %s\\n\\n%s tests passed, %s tests failed out of 1\\n\\nTotal Test time\\n' "$*" $PASSED > $folder/ctest.txt
"""


class CiRun(Project):
    def setUp(self):
        super().setUp()
        self.copy(".ci/run")
        for script in ("install_packages.sh", "format.sh", "check_tidy.py"):
            self.write(f"scripts/{script}", f"#!/bin/sh\necho this is {script}\n", executable=True)
        self.write("scripts/check_layers.py", "print('this is check_layers.py')")
        self.write("scripts/test.sh", TEST.replace("$PASSED", "100% 0"), executable=True)

    def test_all_stages(self):
        code, said = self.run_script(".ci/run")
        self.assertEqual(code, 0, said)
        for script in ("format.sh", "check_layers.py", "check_tidy.py"):
            self.assertIn(f"this is {script}", said)
        self.assertEqual(said.count("100% tests passed, 0 tests failed out of 1\nTotal Test time\n"), 2, said)
        self.assertIn("all stages passed", said)
        self.assertIn("--asan-readers -L fast", (self.folder / "build/asan/ctest.txt").read_text())

    def test_a_failed_stage_is_named_and_the_others_run(self):
        self.write("scripts/format.sh", "#!/bin/sh\nexit 1\n", executable=True)
        self.write("scripts/check_layers.py", "raise SystemExit(1)")
        code, said = self.run_script(".ci/run")
        self.assertEqual(code, 1, said)
        self.assertIn("failed: format,layers", said)
        self.assertIn("this is check_tidy.py", said)
        self.assertEqual(said.count("100% tests passed"), 2, said)

    def test_no_test_is_not_an_earlier_result(self):
        self.run_script(".ci/run")
        self.write("scripts/test.sh", "#!/bin/sh\nexit 1\n", executable=True)
        code, said = self.run_script(".ci/run")
        self.assertEqual(code, 1, said)
        self.assertNotIn("tests passed", said)
        self.assertIn("no test ran", said)


if __name__ == "__main__":
    unittest.main()
