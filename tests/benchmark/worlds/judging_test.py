"""The judge of worlds.py, on results whose verdict is known, and what a seed stands for."""
import csv
import math
import pathlib
import random
import tempfile
import unittest

import worlds

FRAMES, RATE_HZ, RADIUS_PX, SIGMA_PX = 200, 50, 4, 0.05
PLACES = {"ankle": (400, 600), "knee": (430, 440), "hip": (300, 300), "waist": (290, 200), "r_thigh1": (360, 360)}


def write(path, table):
    with open(path, "w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(table)
        out.writerows(zip(*table.values()))


class Judge(unittest.TestCase):
    """A film of a leg that moves to the right at 100 px/s while the knee flexes at 50 deg/s, tracked with errors as large as is said."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.world = {"radius_px": RADIUS_PX}
        self.sources = list(range(FRAMES))

    def verdict(self, change=lambda tracks, kinematics: None):
        it = random.Random(1)
        times = [source / RATE_HZ for source in self.sources]
        stamps = [frame / RATE_HZ for frame in range(len(times))]
        repeated = [int(i > 0 and source == self.sources[i - 1]) for i, source in enumerate(self.sources)]
        truth = {"frame": range(len(times)), "time_s": times, "repeated": repeated, "knee_deg": [50 * t for t in times]}
        tracks = {"frame": range(len(times)), "time_s": stamps}
        for name, (x, y) in PLACES.items():
            truth |= {f"{name}_x_px": [x + 100 * t for t in times], f"{name}_y_px": [y] * len(times), f"{name}_visible": [1] * len(times)}
            tracks |= {f"{name}_x_px": [x + 100 * t + it.gauss(0, SIGMA_PX) for t in times],
                       f"{name}_y_px": [y + it.gauss(0, SIGMA_PX) for t in times],
                       f"{name}_sigma_px": [SIGMA_PX] * len(times), f"{name}_status": ["detected"] * len(times)}
        motion = {"time_s": [frame / RATE_HZ for frame in range(FRAMES)], "knee_deg": [50 * frame / RATE_HZ for frame in range(FRAMES)]}
        angles = {"frame": range(len(times)), "time_s": stamps, "knee_deg": [50 * t + it.gauss(0, 0.1) for t in stamps],
                  "knee_raw_deg": [50 * t + it.gauss(0, 0.2) for t in times], "knee_sigma_deg": [0.1] * len(times)}
        change(tracks, angles)
        for name, table in (("truth", truth), ("motion", motion), ("tracks", tracks), ("kinematics", angles)):
            write(self.folder / f"{name}.csv", table)
        return worlds.judge(self.world, self.folder, self.folder, 0, "")

    def test_what_is_right(self):
        row = self.verdict()
        self.assertEqual((row["verdict"], row["why"], row["recall"], row["time_ms"]), ("right", "", 1, 0))
        self.assertAlmostEqual(row["z"], 1, delta=0.1)
        self.assertAlmostEqual(row["z_hip"], 1, delta=0.15)
        self.assertAlmostEqual(row["knee_z"], 1, delta=0.2)
        self.assertAlmostEqual(row["ratio"], 0.5, delta=0.1)

    def test_a_mark_beside_its_marker_is_wrong(self):
        def move(tracks, _):
            tracks["hip_y_px"][70] += RADIUS_PX + 1
        row = self.verdict(move)
        self.assertEqual(row["verdict"], "wrong")
        self.assertRegex(row["why"], r"^hip is 5 px off \(frame 70; 1 frames\)$")

    def test_a_filled_sample_is_no_mark(self):
        def fill(tracks, _):
            tracks["hip_y_px"][70] += RADIUS_PX + 1
            tracks["hip_status"][70] = "filled"
        row = self.verdict(fill)
        self.assertEqual((row["verdict"], row["recall"]), ("right", 1 - 1 / (4 * FRAMES)))

    def test_a_swapped_name_is_wrong_and_told(self):
        def swap(tracks, _):
            for axis in "xy":
                tracks[f"hip_{axis}_px"], tracks[f"r_thigh1_{axis}_px"] = tracks[f"r_thigh1_{axis}_px"], tracks[f"hip_{axis}_px"]
        row = self.verdict(swap)
        self.assertEqual(row["verdict"], "wrong")
        self.assertRegex(row["why"], r"^hip is on r_thigh1")

    def test_a_clock_that_is_set_back_is_wrong(self):
        def set_back(tracks, _):
            tracks["time_s"] = [t - 0.03 * (t > 2) for t in tracks["time_s"]]
        row = self.verdict(set_back)
        self.assertEqual(row["verdict"], "wrong")
        self.assertRegex(row["why"], r"^a time 30 ms off")
        self.assertEqual(self.verdict(lambda tracks, _: tracks.update(time_s=[t + 7 for t in tracks["time_s"]]))["verdict"], "right")

    def test_an_angle_that_is_off_is_wrong(self):
        def bend(_, angles):
            angles["knee_deg"][90] += 0.9
        self.assertRegex(self.verdict(bend)["why"], r"^knee (0\.[89]|1\.\d) deg off, \d+\.\d SD \(frame 90; ")

        def bend_less(_, angles):
            for frame in range(90, 95):
                angles["knee_deg"][frame] = 50 * frame / RATE_HZ + 0.4
        self.assertRegex(self.verdict(bend_less)["why"], "[5-7] frames")  # by chance, another one or two

        def bend_but_say_so(_, angles):
            bend_less(_, angles)
            angles["knee_sigma_deg"][90:95] = [0.3] * 5
        self.assertEqual(self.verdict(bend_but_say_so)["verdict"], "right")

    def test_sigmas_and_recall(self):
        def widen(tracks, _):
            for name in worlds.LEG:
                tracks[f"{name}_sigma_px"] = [2 * SIGMA_PX] * FRAMES
        self.assertRegex(self.verdict(widen)["why"], r"^error/sigma 0\.(49|50|51)$")

        def lose(tracks, _):
            tracks["knee_status"][:60] = ["filled"] * 60
        row = self.verdict(lose)
        self.assertEqual((row["verdict"], row["why"]), ("poor", "recall 0.93"))

    def test_a_repeated_picture_counts_for_the_angle_alone(self):
        self.sources = [min(i, 100) if i < 130 else i for i in range(FRAMES)]  # frozen for 0.6 s
        self.assertEqual(self.verdict()["verdict"], "right")

        def stale(_, angles):
            angles["knee_deg"][100:130] = [50 * 2.0] * 30
        self.assertRegex(self.verdict(stale)["why"], "^knee 29.0 deg off")

    def test_an_error_is_asked_or_refused(self):
        def verdict(message):
            return worlds.judge(self.world, self.folder, self.folder, 1, message)["verdict"]
        self.assertEqual(verdict("lake-track: marker 'hip' …"), "refused")
        (self.folder / "candidates.csv").touch()
        self.assertEqual(verdict("lake-track: which is the hip? …"), "asked")
        self.assertEqual(verdict("lake-track: no leg was found among the 7 detections: …"), "refused")


class Draw(unittest.TestCase):
    def test_a_seed_stands_for_one_recording(self):
        self.assertEqual([worlds.draw(seed) for seed in range(1, 30)], [worlds.draw(seed) for seed in range(1, 30)])
        self.assertGreater(len({worlds.describe(worlds.draw(seed)) for seed in range(1, 30)}), 27)

    def test_every_kind_is_drawn(self):
        told = " ".join(worlds.describe(worlds.draw(seed)) for seed in range(1, 400))
        for kind in ("drawn", "walks in", "extra markers", "clutter", "hidden", "variable rate", "converted to", "dropped", "a gap", "frozen",
                     "changing light", "processed", "x264", "x265", "MPEG-4", "MJPEG", "24 Hz", "120 Hz", "1920x1080"):
            self.assertIn(kind, told)

    def test_a_converter_shows_the_nearest_picture_before(self):
        self.assertEqual(worlds.converted(9, 60, 30), [0, 2, 4, 6, 8])
        self.assertEqual(worlds.converted(4, 30, 60), [0, 0, 1, 1, 2, 2, 3])
        for rate, to_rate in ((60, 25), (60, 50), (50, 30), (25, 30), (120, 25)):
            sources = worlds.converted(600, rate, to_rate)
            for frame, source in enumerate(sources):
                self.assertLessEqual(abs(frame / to_rate - source / rate), 0.5 / to_rate + 0.5 / rate + 1e-9)

    def test_a_camera_that_is_scaled_sees_the_same_rays(self):
        world = {"size": [1280, 720], "processing": {"size": [960, 540]}}
        text = worlds.scaled_camera("image_width: 1280\nimage_height: 720\ncamera_matrix: !!opencv-matrix\n   data: [ 1000., 0., 639.5, 0., 1000.,\n"
                                    "       359.5, 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   data: [ 0.1, 0., 0., 0., 0. ]\n", world)
        self.assertIn("image_width: 960\nimage_height: 540\n", text)
        self.assertIn("[750.0, 0.0, 479.5, 0.0, 750.0, 269.5, 0.0, 0.0, 1.0]", text)
        self.assertIn("[ 0.1, 0., 0., 0., 0. ]", text)

    def test_nothing_is_right_where_nothing_is_known(self):
        self.assertTrue(math.isnan(worlds.rms(worlds.numbers(["", ""]))))


if __name__ == "__main__":
    unittest.main()
