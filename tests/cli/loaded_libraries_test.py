"""What a program does not use it does not load: libav brings 128 libraries, half of a short program's start."""
import os
import pathlib
import subprocess
import unittest

BIN = pathlib.Path(os.environ["LAKE_BIN"])
WITHOUT_FILMS = ("lake-axis", "lake-compare", "lake-convert", "lake-gait", "lake-info", "lake-loads", "lake-optimize", "lake-redesign",
                 "lake-stroke", "lake-symmetry")


class LoadedLibraries(unittest.TestCase):
    def test_programs_without_films_do_not_load_libav(self):
        for program in WITHOUT_FILMS:
            with self.subTest(program):
                said = subprocess.run(["ldd", BIN / program], capture_output=True, text=True, check=True).stdout
                self.assertIn("libfmt", said)
                self.assertNotIn("libav", said)


if __name__ == "__main__":
    unittest.main()
