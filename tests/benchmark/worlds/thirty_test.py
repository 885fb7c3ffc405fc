"""Recordings of worlds.py: what came out right stays right, and no other of those that were measured goes wrong.

Ten of them, 70 s of processor time; LAKE_WORLDS=all in the environment takes all thirty (some 200 s).
"""
import argparse
import concurrent.futures
import os
import pathlib
import tempfile
import unittest

import worlds

# 22 real motions and 8 drawn ones. Of the 24 that were measured these came out right; wrong are the knee angles of 1001
# (4.6 SD off in six frames), 1006 (4.1 SD in five) and 2004 (18 SD in 66, with extra markers). The others were poor,
# asked or refused. What was not measured is judged and shown.
REAL, DRAWN = range(1001, 1023), range(2001, 2009)
RIGHT = {1002, 1003, 1004, 1008, 1009, 1010, 1012, 1019, 1020, 2001, 2003, 2008}
WRONG = {1001, 1006, 2004}
MEASURED = RIGHT | WRONG | {1005, 1007, 1011, 1013, 1014, 1016, 1021, 2002, 2006}
BY_DEFAULT = {1001, 1002, 1004, 1010, 1012, 1013, 1019, 2001, 2002, 2008}


class Thirty(unittest.TestCase):
    def judged(self, kind, seeds):
        if os.environ.get("LAKE_WORLDS") != "all":
            seeds = sorted(BY_DEFAULT & set(seeds))
        with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            out = pathlib.Path(folder)
            options = argparse.Namespace(bin=pathlib.Path(os.environ["LAKE_BIN"]), out=out, csv=out / "rows.csv", keep=False, rejudge=False)
            rows = list(pool.map(lambda seed: worlds.run(worlds.draw(seed, [kind], brief=True), options), seeds))
        print("\n" + worlds.table(rows))
        of = {verdict: {row["seed"] for row in rows if row["verdict"] == verdict} for verdict in worlds.VERDICTS}
        self.assertEqual(of["not made"], set())
        self.assertEqual(of["wrong"] & MEASURED - WRONG, set())
        self.assertEqual(RIGHT & set(seeds) - of["right"], set())

    @unittest.skipUnless(worlds.SHARED.is_dir(), f"no recordings of people in {worlds.SHARED}")
    def test_real_motions(self):
        self.judged("real", REAL)

    def test_drawn_motions(self):
        self.judged("drawn", DRAWN)


if __name__ == "__main__":
    unittest.main()
