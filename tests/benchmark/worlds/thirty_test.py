"""Thirty recordings of worlds.py: none may come out wrong, and no fewer right than the tracker has reached."""
import argparse
import concurrent.futures
import os
import pathlib
import tempfile
import unittest

import worlds

# Of 22 real motions and 8 drawn ones, by what `lake track` reaches; a tracker that does better may raise them.
REAL, DRAWN = range(1001, 1023), range(2001, 2009)
RIGHT_AT_LEAST = {"real": 0, "drawn": 0}
WRONG_AT_MOST = {"real": 22, "drawn": 8}


class Thirty(unittest.TestCase):
    def judged(self, kind, seeds):
        with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            out = pathlib.Path(folder)
            options = argparse.Namespace(bin=pathlib.Path(os.environ["LAKE_BIN"]), out=out, csv=out / "rows.csv", keep=False, rejudge=False)
            rows = list(pool.map(lambda seed: worlds.run(worlds.draw(seed, [kind], brief=True), options), seeds))
        print("\n" + worlds.table(rows))
        counts = dict(zip(worlds.VERDICTS, worlds.counts(rows)))
        self.assertEqual(counts["not made"], 0)
        self.assertLessEqual(counts["wrong"], WRONG_AT_MOST[kind])
        self.assertGreaterEqual(counts["right"], RIGHT_AT_LEAST[kind])

    @unittest.skipUnless(worlds.SHARED.is_dir(), f"no recordings of people in {worlds.SHARED}")
    def test_real_motions(self):
        self.judged("real", REAL)

    def test_drawn_motions(self):
        self.judged("drawn", DRAWN)


if __name__ == "__main__":
    unittest.main()
