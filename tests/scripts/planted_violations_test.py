"""The checks that CI makes find what is planted for them, and nothing where nothing is planted."""
import shutil
import subprocess
import unittest

from project import Project

ODR_CMAKE = """cmake_minimum_required(VERSION 3.25)
project(lake LANGUAGES CXX)
add_library(lake_build_options INTERFACE)
foreach(room one other)
  add_library(lake_${room} STATIC ${room}.cc)
  set_property(GLOBAL APPEND PROPERTY LAKE_ROOMS lake_${room})
endforeach()
add_library(lake_program STATIC program.cc)
add_subdirectory(tests/odr)
"""
MODULE = """namespace {space} {{
struct Interval {{
  virtual ~Interval() = default;
  {members};
}};
double {function}() {{ return Interval().low; }}
}}
"""


class Layers(Project):
    def setUp(self):
        super().setUp()
        self.copy("scripts/check_layers.py", "libs")

    def test_none_as_it_is(self):
        code, said = self.run_script("python3", "scripts/check_layers.py")
        self.assertEqual(code, 0, said)

    def test_include_of_what_is_above(self):
        header = next((self.folder / "libs").rglob("lake/core/error.h"))
        header.write_text(header.read_text() + '#include "lake/gait/leg_fit.h"\n')
        code, said = self.run_script("python3", "scripts/check_layers.py")
        self.assertNotEqual(code, 0, said)
        self.assertRegex(said, r"lake/core/error\.h:\d+: core .*gait")

    def test_link_to_what_is_above(self):
        build = next(path.parents[3] for path in (self.folder / "libs").rglob("lake/core/error.h")) / "CMakeLists.txt"
        build.write_text(build.read_text() + "target_link_libraries(lake_core PRIVATE lake::gait)\n")
        code, said = self.run_script("python3", "scripts/check_layers.py")
        self.assertNotEqual(code, 0, said)
        self.assertRegex(said, r"CMakeLists\.txt:\d+: core .*gait")


class OneDefinitionRule(Project):
    def setUp(self):
        super().setUp()
        self.copy("scripts/check_odr.sh", "CMakePresets.json", "tests/odr")
        self.write("CMakeLists.txt", ODR_CMAKE)
        self.write("program.cc", "int Program() { return 1; }\n")
        self.write("one.cc", MODULE.format(space="lake", members="double low = 0, high = 1", function="One"))

    def check(self, space, members="float low = 0"):
        self.write("other.cc", MODULE.format(space=space, members=members, function="Other"))
        return self.run_script("scripts/check_odr.sh")

    def test_two_classes_of_one_name(self):
        code, said = self.check("lake")
        self.assertNotEqual(code, 0, said)
        self.assertIn("Interval", said)
        self.assertIn("-Werror=odr", said)

    def test_a_namespace_for_each(self):
        code, said = self.check("lake::other")
        self.assertEqual(code, 0, said)
        self.assertIn("one definition rule: no violation", said)


@unittest.skipUnless(shutil.which("clang-tidy-14") and shutil.which("clang++-14"), "clang-tidy-14 is not installed")
class Tidy(Project):
    """Which sources are looked at; the clone has no origin/main, then a branch beside it."""

    def setUp(self):
        super().setUp()
        self.copy("scripts/check_tidy.py", "CMakePresets.json", ".clang-tidy")
        self.write("CMakeLists.txt", "cmake_minimum_required(VERSION 3.25)\nproject(lake LANGUAGES CXX)\n"
                   "add_custom_target(lake_commit)\nadd_library(lake_a STATIC libs/a.cc libs/b.cc)\n")
        self.write(".gitignore", "/build/\n")
        self.write("libs/a.cc", "int* pointer = 0;\n")
        self.git("init", "-q", "-b", "main")
        self.write("libs/b.cc", "int* other = nullptr;\n")
        self.commit()

    def git(self, *arguments):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *arguments], cwd=self.folder, check=True)

    def commit(self):
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "a")

    def test_without_origin_the_last_commit(self):
        code, said = self.run_script("scripts/check_tidy.py")
        self.assertNotEqual(code, 0, said)
        self.assertIn("modernize-use-nullptr", said)
        self.write("libs/b.cc", "int* another = nullptr;\n")
        self.commit()
        code, said = self.run_script("scripts/check_tidy.py")
        self.assertEqual(code, 0, said)
        self.assertIn("0 with findings", said)

    def test_since_the_branch_left_origin(self):
        self.git("update-ref", "refs/remotes/origin/main", "HEAD")
        self.git("checkout", "-q", "-b", "branch")
        self.write("libs/b.cc", "int* another = 0;\n")
        self.commit()
        self.write("README.md", "")
        self.commit()
        code, said = self.run_script("scripts/check_tidy.py")
        self.assertNotEqual(code, 0, said)
        self.assertIn("libs/b.cc", said)
        self.assertNotIn("libs/a.cc:", said)


if __name__ == "__main__":
    unittest.main()
