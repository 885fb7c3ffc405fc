"""The release's tarball: the same bytes however often it is made, of what is committed and nothing else."""
import os
import subprocess
import tarfile
import time

import unittest

from project import Project


class Tarball(Project):
    def setUp(self):
        super().setUp()
        self.copy("scripts/package/tarball.sh")
        self.write("CMakeLists.txt", "project(lake VERSION 1.2.3 LANGUAGES CXX)\n")
        self.git("init", "--quiet")
        self.git("add", ".")
        self.git("-c", "user.name=A", "-c", "user.email=a@b.c", "commit", "--quiet", "-m", "First")

    def git(self, *words):
        subprocess.run(["git", *words], cwd=self.folder, check=True)

    def make(self, folder, **environment):
        done = subprocess.run(["scripts/package/tarball.sh", "HEAD", folder], cwd=self.folder, check=True, text=True, stdout=subprocess.PIPE,
                              env={**os.environ, **environment})
        return (self.folder / folder / "lake-1.2.3.tar.gz").read_bytes(), done.stdout

    def test_two_runs_have_the_same_bytes(self):
        first, said = self.make("a")
        time.sleep(1.1)  # a second later, what is not committed touched, another time zone and umask
        os.utime(self.folder / "CMakeLists.txt")
        self.write("scrap.txt", "not committed")
        previous = os.umask(0o077)
        self.addCleanup(os.umask, previous)
        second, _ = self.make("b", TZ="Asia/Tokyo", LC_ALL="C")
        self.assertEqual(first, second)
        self.assertRegex(said, r"\A[0-9a-f]{64}  a/lake-1\.2\.3\.tar\.gz\n\Z")

    def test_it_holds_what_is_committed(self):
        self.write("scrap.txt", "not committed")
        self.make("a")
        with tarfile.open(self.folder / "a/lake-1.2.3.tar.gz") as tarball:
            files = {entry.name: entry for entry in tarball if entry.isfile()}
        self.assertEqual(set(files), {"lake-1.2.3/CMakeLists.txt", "lake-1.2.3/scripts/package/tarball.sh"})
        self.assertEqual({entry.uname for entry in files.values()}, {"root"})
        self.assertEqual(files["lake-1.2.3/scripts/package/tarball.sh"].mode, 0o755)

    def test_without_a_version_there_is_none(self):
        self.write("CMakeLists.txt", "project(lake)\n")
        self.git("-c", "user.name=A", "-c", "user.email=a@b.c", "commit", "--quiet", "-am", "Second")
        code, said = self.run_script("scripts/package/tarball.sh", "HEAD", "a")
        self.assertEqual(code, 1)
        self.assertIn("names no version", said)
        self.assertFalse((self.folder / "a").exists())


if __name__ == "__main__":
    unittest.main()
