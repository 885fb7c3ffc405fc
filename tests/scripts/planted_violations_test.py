"""The checks that CI makes find what is planted for them, and nothing where nothing is planted."""
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from project import ROOT, Project

ODR_CMAKE = """cmake_minimum_required(VERSION 3.25)
project(lake LANGUAGES CXX)
add_library(lake_build_options INTERFACE)
foreach(room one other)
  add_library(lake_${room} OBJECT ${room}.cc)
  set_property(GLOBAL APPEND PROPERTY LAKE_ROOMS lake_${room})
endforeach()
add_library(lake_program STATIC program.cc)
add_subdirectory(tests/odr)
"""
ROOM = """namespace {space} {{
struct Interval {{
  virtual ~Interval() = default;
  {members};
}};
double {function}() {{ return Interval().low; }}
}}
"""


class Layers(Project):
    """All plant in one copy of the rooms, each takes away again what it planted."""

    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.rooms = pathlib.Path(temporary.name)
        shutil.copytree(ROOT / "libs", cls.rooms / "libs")
        (cls.rooms / "scripts").mkdir()
        shutil.copy(ROOT / "scripts/check_layers.py", cls.rooms / "scripts")

    def setUp(self):
        self.folder = self.rooms

    def room(self, name):
        return next((self.folder / "libs").rglob(f"include/lake/{name}")).parents[2]

    def write(self, path, text):
        file = self.folder / path
        if file.exists():
            self.addCleanup(file.write_text, file.read_text())
        else:
            self.addCleanup(file.unlink)
        super().write(path, text)

    def plant(self, path, text):
        self.write(path.relative_to(self.folder), (path.read_text() if path.exists() else "") + text)

    def plant_in_header(self, room, text):
        self.plant(next((self.room(room) / "include/lake" / room).glob("*.h")), text)

    def assert_found(self, pattern):
        code, said = self.run_script("python3", "scripts/check_layers.py")
        self.assertNotEqual(code, 0, said)
        self.assertRegex(said, pattern)

    def test_none_as_it_is(self):
        code, said = self.run_script("python3", "scripts/check_layers.py")
        self.assertEqual(code, 0, said)

    def test_include_of_what_is_above(self):
        self.plant(self.room("core") / "include/lake/core/error.h", '#include "lake/gait/leg_fit.h"\n')
        self.assert_found(r"lake/core/error\.h:\d+: core .*gait")

    def test_include_that_no_link_reaches(self):
        self.plant(self.room("tracking") / "src/planted.cc", '#  include <lake/exchange/mot.h>\n')
        self.assert_found(r"planted\.cc:1: tracking .*exchange.*link lines do not reach it")

    def test_public_header_includes_what_is_linked_privately(self):
        self.plant_in_header("report", '#include "lake/compare/registration.h"\n')
        self.assert_found(r"\.h:\d+: report .*compare.*public link lines")

    def test_include_by_a_relative_path(self):
        self.plant(self.room("gait") / "src/planted.cc", '#include "../../camera/src/planted.h"\n')
        self.assert_found(r"planted\.cc:1: .*leaves the folder")

    def test_link_to_what_is_above(self):
        build = self.room("core") / "CMakeLists.txt"
        as_it_is = build.read_text()
        for target in ("lake::gait", "lake_gait"):
            with self.subTest(target):
                self.write(build.relative_to(self.folder), as_it_is + f"target_link_libraries(lake_core PRIVATE {target})\n")
                self.assert_found(r"CMakeLists\.txt:\d+: core .*gait")

    def test_circle_within_a_layer(self):
        self.plant(self.room("camera") / "CMakeLists.txt", "target_link_libraries(lake_camera PRIVATE lake::tracking)\n")
        self.assert_found(r"camera uses itself in a circle: camera -> tracking -> camera")

    def test_room_in_no_layer(self):
        self.write("libs/attic/box/CMakeLists.txt", "lake_add_room(box)\n")
        self.assert_found(r"attic is no layer")

    def test_two_rooms_of_one_name(self):
        self.write("libs/measure/other/CMakeLists.txt", "lake_add_room(nlp)\n")
        self.assert_found(r"there is a room nlp already")

    def test_source_in_no_room(self):
        self.write("libs/measure/planted.cc", "")
        self.assert_found(r"measure/planted\.cc: lies in no room")

    def test_header_under_another_name(self):
        self.plant(self.room("gait") / "include/lake/legs/planted.h", "")
        self.assert_found(r"planted\.h: public headers of gait are in include/lake/gait")

    def test_namespace_of_another_room(self):
        planted = (self.room("gait") / "src/planted.cc").relative_to(self.folder)
        for space in ("lake", "lake::camera", "lake::gaits"):
            with self.subTest(space):
                self.write(planted, f"namespace {space} {{\n}}\n")
                self.assert_found(r"planted\.cc:1: gait has its names in lake::gait")


class OneDefinitionRule(Project):
    def setUp(self):
        super().setUp()
        self.copy("scripts/check_odr.sh", "scripts/build.sh", "CMakePresets.json", "tests/odr")
        self.write("CMakeLists.txt", ODR_CMAKE)
        self.write("program.cc", "int Program() { return 1; }\n")
        self.write("one.cc", ROOM.format(space="lake", members="double low = 0, high = 1", function="One"))

    def check(self, space, members="float low = 0"):
        self.write("other.cc", ROOM.format(space=space, members=members, function="Other"))
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

    def test_of_many_sources_those_that_changed_most(self):
        self.write("libs/a.cc", "int* pointer = nullptr;\n")
        self.write("libs/b.cc", "int* other = 0;\nint* another = 0;\n")
        self.commit()
        code, said = self.run_script("env", "LAKE_TIDY_MOST=1", "scripts/check_tidy.py")
        self.assertNotEqual(code, 0, said)
        self.assertIn("2 sources changed: the 1 with the most changed lines", said)
        self.assertIn("libs/b.cc", said)


if __name__ == "__main__":
    unittest.main()
