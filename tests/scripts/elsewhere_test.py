"""The tests do not depend on where the clone stands: one of each kind, in a clone that only its owner can enter, in a folder whose name has
a blank and a quote, with the programs that were built already; and the build is made outside a source tree that cannot be written."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from project import ROOT

sys.path.insert(0, str(ROOT / "tests/faults"))
from limits import limited

BIN = pathlib.Path(os.environ["LAKE_BIN"])


class Elsewhere(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        private = pathlib.Path(temporary.name)
        private.chmod(0o700)
        cls.clone = private / "it's a clone"
        shutil.copytree(ROOT, cls.clone, ignore=shutil.ignore_patterns("build", ".git", "lake-out", "__pycache__"))
        cls.programs = cls.clone / "build/test/bin"
        cls.programs.parent.mkdir(parents=True)
        cls.programs.symlink_to(BIN)

    def expect_success(self, *command, folder=".", **options):
        environment = {name: value for name, value in os.environ.items() if not name.startswith(("CTEST_", "LAKE_", "GTEST_"))}
        places = {"LAKE": self.programs / "lake", "LAKE_BIN": self.programs, "LAKE_SOURCE": self.clone}
        done = subprocess.run(command, cwd=self.clone / folder, env={**environment, **places}, text=True, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options)
        self.assertEqual(done.returncode, 0, done.stdout)
        return done.stdout

    def expect_cases(self, program, cases):
        if not (BIN / program).exists():
            self.skipTest(f"{program} is not built")
        self.assertIn("[  PASSED  ]", self.expect_success(self.programs / program, f"--gtest_filter={cases}"))

    def test_that_read_the_sources(self):
        self.expect_cases("lake_linkage_test", "PaperTables.*")

    def test_that_run_a_program(self):
        self.expect_cases("lake_linkage_test", "Simulate.RefusesWrongUsage")

    def test_that_run_a_program_on_the_sources(self):
        self.expect_cases("lake_actuator_test", "StrokeProgramTest.WritesProgramAndFirmware")

    def test_that_compile_the_firmware(self):
        self.expect_cases("lake_actuator_test", "ControllerTest.PlanFollowsTheScheduleTickByTick")

    def test_of_scripts(self):
        case = "two_commands_test.TwoCommands.test_demo_then_test_then_demo"
        self.expect_success(sys.executable, "-B", "-m", "unittest", case, folder="tests/scripts")

    def test_of_documents(self):
        self.expect_success(sys.executable, "-B", "-m", "unittest", "documents_test", folder="tests/scripts")

    def test_of_completion(self):
        case = "completion_test.Completion"
        self.expect_success(sys.executable, "-B", "-m", "unittest", case, folder="tests/completion")

    def test_under_faults(self):
        inputs = self.clone / "build/inputs"
        self.expect_success(sys.executable, "-B", "programs.py", inputs, folder="tests/faults")
        for what in "folder", "disk":
            self.expect_success(sys.executable, "-B", "limits.py", inputs, what, "--quick", "--only", "calibrate-board", "export-step",
                                folder="tests/faults")

    def test_that_building_leaves_the_sources_alone(self):
        build = self.clone.parent / "a build's folder"
        for folder in [self.clone, *(path for path in self.clone.rglob("*") if path.is_dir() and not path.is_symlink())]:
            mode = folder.stat().st_mode
            self.addCleanup(folder.chmod, mode)
            folder.chmod(mode & ~0o222)
        self.expect_success("cmake", "--preset", "test", "-B", build, preexec_fn=limited("folder", None))
        self.expect_success("cmake", "--build", build, "--target", "lake_commit", preexec_fn=limited("folder", None))


if __name__ == "__main__":
    unittest.main()
