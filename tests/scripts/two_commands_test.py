"""The README's two commands do what they say in one clone, in any order, whatever was configured there before."""
import unittest

from project import Project

CMAKE = """cmake_minimum_required(VERSION 3.25)
project(lake LANGUAGES NONE)
option(LAKE_BUILD_TESTS "Build the tests" ON)
add_custom_target(programs ALL COMMAND ${CMAKE_COMMAND} -E copy ${CMAKE_SOURCE_DIR}/lake.sh ${CMAKE_BINARY_DIR}/bin/lake)
if(LAKE_BUILD_TESTS)
  enable_testing()
  %s
endif()
"""
ONE_TEST = "add_test(NAME Only.Test COMMAND ${CMAKE_COMMAND} -E true)"
LAKE = "#!/bin/sh\nmkdir -p \"$4\"\necho ran > \"$4/report.html\"\n"


class TwoCommands(Project):
    def setUp(self):
        super().setUp()
        self.copy("scripts/demo.sh", "scripts/test.sh", "scripts/build.sh", "CMakePresets.json")
        self.write("scripts/install_packages.sh", "#!/bin/sh\n", executable=True)
        self.write("scripts/check_layers.py", "")
        self.write("lake.sh", LAKE, executable=True)
        self.write("CMakeLists.txt", CMAKE % ONE_TEST)

    def expect_the_test_to_run(self, preset="test", *arguments):
        code, said = self.run_script("scripts/test.sh", *arguments)
        self.assertEqual(code, 0, said)
        self.assertIn("100% tests passed, 0 tests failed out of 1", said)
        self.assertIn("100% tests passed", (self.folder / "build" / preset / "ctest.txt").read_text())

    def test_demo_then_test_then_demo(self):
        code, said = self.run_script("scripts/demo.sh", "out")
        self.assertEqual(code, 0, said)
        self.assertIn("out/report.html", said)
        self.expect_the_test_to_run()
        code, said = self.run_script("scripts/demo.sh", "again")
        self.assertEqual(code, 0, said)

    def test_each_step_of_the_build_says_what_is_left(self):
        code, said = self.run_script("scripts/demo.sh", "out")
        self.assertEqual(code, 0, said)
        self.assertRegex(said, r"\[1/1, .* left\] ")

    def test_nightly_runs_also_what_the_tests_leave_out(self):
        self.write("CMakeLists.txt", CMAKE % (ONE_TEST + "\n  add_test(NAME Long.Test COMMAND ${CMAKE_COMMAND} -E true)\n"
                                              "  set_tests_properties(Long.Test PROPERTIES LABELS nightly)"))
        for script in ("check_odr.sh", "install_packages.sh"):
            self.write(f"scripts/{script}", "#!/bin/sh\n", executable=True)
        self.expect_the_test_to_run()
        self.assertNotIn("Long.Test", (self.folder / "build/test/ctest.txt").read_text())
        self.run_script("scripts/test.sh", "--nightly")
        self.assertIn("Only.Test", (self.folder / "build/test/ctest.txt").read_text())
        self.assertIn("Long.Test", (self.folder / "build/test/ctest.txt").read_text())

    def test_what_was_configured_before_does_not_matter(self):
        for preset in ("release", "test", "asan"):
            code, said = self.run_script("cmake", "--preset", preset, "-DLAKE_BUILD_TESTS=OFF", "-DLAKE_SANITIZE=ON",
                                         "-DLAKE_WARNINGS_AS_ERRORS=OFF")
            self.assertEqual(code, 0, said)
        self.expect_the_test_to_run()
        self.expect_the_test_to_run("asan", "--asan")
        cache = (self.folder / "build/test/CMakeCache.txt").read_text()
        self.assertRegex(cache, r"LAKE_WARNINGS_AS_ERRORS:\w+=ON")
        self.assertRegex(cache, r"LAKE_SANITIZE:\w+=OFF")

    def test_no_tests_is_a_failure(self):
        self.write("CMakeLists.txt", CMAKE % "")
        code, said = self.run_script("scripts/test.sh")
        self.assertNotEqual(code, 0, said)
        self.assertIn("No tests were found", said)

    def test_a_name_that_matches_nothing_is_a_failure(self):
        code, said = self.run_script("scripts/test.sh", "-R", "Nothing")
        self.assertNotEqual(code, 0, said)

    def test_a_test_that_fails_is_a_failure(self):
        self.write("CMakeLists.txt", CMAKE % ONE_TEST.replace("true", "false"))
        code, said = self.run_script("scripts/test.sh")
        self.assertNotEqual(code, 0, said)
        self.assertIn("1 tests failed out of 1", said)


if __name__ == "__main__":
    unittest.main()
