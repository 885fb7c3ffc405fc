"""lake live as a laboratory uses it: the built program, rendered films, a pipe, a socket, a full disk, headless Chromium.

The films show an exoskeleton whose joint is where it is known to be. LAKE_BIN: where the programs are."""
import contextlib
import csv
import json
import math
import os
import pathlib
import random
import re
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "review"))
try:
    from browser import DRIVER, PageParts, headless
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
except ImportError:
    DRIVER, PageParts = None, object

BIN = pathlib.Path(os.environ.get("LAKE_BIN", "build/test/bin")).resolve()
SAMPLE = pathlib.Path(os.environ.get("LAKE_SOURCE", pathlib.Path(__file__).resolve().parents[2])) / "data/sts-study"
WAIT_S = 600  # a loaded machine; what is waited for takes some seconds
WORN = (18, 32)  # joint less knee, mm, shank frame
MOVED = (3, 2)  # after the joint was moved
MARKER_AT = (0, -60)  # in those two films the joint's marker, which would cover the knee's otherwise
FILM = ("--exoskeleton", "--repetitions", "2", "--rest", "1", "--pace", "0.8", "--rate", "30", "--seed-number", "38")
RENDERED = os.environ.get("LAKE_WORN_RECORDING")  # where one of WORN is that was rendered so
MM = 96 / 25.4  # CSS px
LETTER_PX = 3000 * math.tan(math.radians(16 / 60)) * MM  # of a capital seen at 16' from 3 m, ISO 9241-303's least
NAMES = ("ankle", "knee", "hip", "waist", "exo_knee")
# Of what lake check judges: that which a recording under way tells of itself.
JUDGED = ("all_seen_share", "radius_px", "contrast_over_noise", "saturated_share", "blur_px", "frame_rate_hz", "repeated_frames",
          "dropped_frames")


def run(*words, **options):
    return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True, **options)


def synth(folder, place, *words):
    run(BIN / "lake-synth", "--exo", f"{place[0]},{place[1]}", *FILM, *words, "--quiet", "-o", folder)


def ffmpeg(*words):
    run("ffmpeg", "-v", "error", "-nostdin", "-y", *words)


def frames_of(film):
    shown = run("ffprobe", "-v", "error", "-count_frames", "-select_streams", "v", "-show_entries", "stream=nb_read_frames",
                "-of", "csv=p=0", film)
    return int(shown.stdout.split()[0].strip(","))  # a transport stream is told of twice


def read_table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


class Live:
    """The program at work; its page's address once it has said it."""

    def __init__(self, folder, *words, **options):
        self.process = subprocess.Popen([str(word) for word in (BIN / "lake-live", *words)], cwd=folder, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True, restore_signals=False, **options)
        self.said = []
        self.address = ""
        for line in self.process.stderr:
            self.said.append(line)
            if line.startswith("http://"):
                self.address = line.strip()
                break

    def ask(self, path, message=None):
        data = None if message is None else json.dumps(message).encode()
        request = urllib.request.Request(self.address + path, data, {"Content-Type": "application/json"})
        with urllib.request.urlopen(request, timeout=WAIT_S) as response:
            return json.load(response)

    def end(self):
        out, err = self.process.communicate(timeout=WAIT_S)
        return self.process.returncode, out, "".join(self.said) + err

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait(WAIT_S)
        self.process.stdout.close()
        self.process.stderr.close()


def send_unevenly(part, write):
    """As a network brings it, in pieces of any size at any time."""
    drawn = random.Random(38)
    data, at = part.read_bytes(), 0
    while at < len(data):
        piece = drawn.randint(1, 20000)
        write(data[at:at + piece])
        at += piece
        time.sleep(drawn.uniform(0, 0.03))


class Camera:
    """A pipe that sends as much of a film as it is told to: no test depends on how fast the machine is."""

    def __init__(self, film):
        self.film = film
        self.data = film.read_bytes()
        self.sent = 0
        self.output, self.input = os.pipe()
        self.writing = threading.Thread()

    def at(self, time_s):
        """The first byte of what was taken at that time."""
        shown = run("ffprobe", "-v", "error", "-select_streams", "v", "-show_entries", "packet=pos,dts_time", "-of", "json", self.film)
        packets = json.loads(shown.stdout)["packets"]
        begin_s = float(packets[0]["dts_time"])
        return next(int(packet["pos"]) for packet in packets if float(packet["dts_time"]) - begin_s >= time_s)

    def send(self, end=None):
        part = self.data[self.sent:end]
        self.sent += len(part)
        before = self.writing

        def write():
            if before.ident:
                before.join()
            written = 0
            with contextlib.suppress(BrokenPipeError):  # the program has ended, which its test tells of
                while written < len(part):
                    written += os.write(self.input, part[written:])

        self.writing = threading.Thread(target=write, daemon=True)
        self.writing.start()

    def is_read_by_another(self):
        """Its end, if it comes, ends the writing."""
        os.close(self.output)

    def end(self):
        self.writing.join(WAIT_S)
        os.close(self.input)


class Films(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="lake-test-")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        if RENDERED:
            (cls.folder / "worn").symlink_to(RENDERED)
        else:
            synth(cls.folder / "worn", WORN)
        cls.film, cls.camera = cls.folder / "worn/video.mp4", cls.folder / "worn/camera.yaml"
        cls.frames = frames_of(cls.film)

    MOVE = r"Move the joint 18 mm back and 32 mm down \(± [12] mm\)"

    def live(self, *words, camera=None, **options):
        # Rendered in the leg's plane; a ruler would say so to 5 mm.
        live = Live(self.folder, *words, "--camera", camera or self.camera, "--depth", "exo_knee=0±5", "--no-overlay", **options)
        self.addCleanup(live.close)
        return live

    def seeds(self):
        truth = read_table(self.folder / "worn/truth.csv")[0]
        return [f"--seed={name}={truth[name + '_x_px']},{truth[name + '_y_px']}"
                for name in NAMES]

    def until(self, is_so, wait_s=WAIT_S):
        end = time.monotonic() + wait_s
        while not (found := is_so()):
            self.assertLess(time.monotonic(), end, "waited in vain")
            time.sleep(0.05)
        return found

    def expect_place(self, place, truth):
        for axis in (0, 1):
            self.assertLessEqual(abs(place["offset_mm"][axis] - truth[axis]), place["half_width_mm"][axis])

    def expect_trial(self, folder, frames, rises):
        """Every frame is recorded and was looked at; each rise's interval holds the truth; the trial can be compared."""
        live = json.loads((folder / "live.json").read_text())
        self.assertEqual(frames_of(folder / "video.mkv"), frames)
        self.assertEqual(live["frames"], frames)
        self.assertEqual(len(read_table(folder / "live_tracks.csv")), frames)
        self.assertEqual(live["damaged_frames"], 0)
        self.assertLess(live["difference"]["rms_px"], 0.1)
        for marker in live["difference"]["markers"].values():
            self.assertGreater(marker["frames"], 0.4 * frames)
        self.assertEqual(len(live["rises"]), rises)
        for rise in live["rises"]:
            self.expect_place(rise["place"], WORN)
        run(BIN / "lake-compare", folder, folder, "--exo-knee", "exo_knee", "-o", folder.with_suffix(".compared"))
        return live

    def watched(self, film, *words, rises=0):
        """What the page is told once all of a film has come, its last frames after so many rises are known, and no end of it."""
        frames = frames_of(film)
        camera = Camera(film)
        camera.send(camera.at(9.5) if rises else None)
        live = self.live("-", "--patience", WAIT_S, "-o", film.stem, *words, stdin=camera.output)
        camera.is_read_by_another()
        self.until(lambda: len(live.ask("state")["rises"]) >= rises)
        camera.send()
        state = self.until(lambda: (now := live.ask("state"))["frames"] == frames
                           and any(f" of {frames} frames seen" in check["shown"] for check in now["checks"]) and now)
        view = live.ask("view", {"after": -1})
        live.close()
        camera.end()
        return state, view

    def as_sent(self, name, *words, film=None):
        """The film as a camera sends it: each picture is whole as it comes, and stamps are in whole milliseconds."""
        ffmpeg("-i", film or self.film, "-c:v", "mjpeg", "-q:v", 2, "-pix_fmt", "yuvj420p", *words, self.folder / f"{name}.mkv")
        return self.folder / f"{name}.mkv"


class Streams(Films):
    def test_a_replayed_film_becomes_a_trial(self):
        code, out, err = self.live(self.film, "--replay", "-o", "replayed").end()
        self.assertEqual(code, 0, err)
        live = self.expect_trial(self.folder / "replayed", self.frames, 2)
        self.assertRegex(out, self.MOVE)
        # With the mean of two rises and no error but noise, the millimetre that is asked for after three.
        self.assertLess(math.dist(live["place"]["offset_mm"], WORN), 1)

    def test_a_pipe_in_which_a_seed_names_the_joint_at_once(self):
        ffmpeg("-i", self.film, "-c", "copy", self.folder / "film.ts")
        with open(self.folder / "film.ts", "rb") as film:
            code, _, err = self.live("-", "-o", "piped", *self.seeds(), stdin=film).end()
            self.assertEqual(code, 0, err)
        self.assertEqual(read_table(self.folder / "piped/live_tracks.csv")[0]["exo_knee_status"], "detected")
        self.expect_trial(self.folder / "piped", self.frames, 2)

    def parts(self, *second):
        """Of the film, with a gap of half a second and more in its stamps."""
        coded = ("-c:v", "libx264", "-preset", "veryfast", "-g", 15, "-bf", 0, "-crf", 18)
        ffmpeg("-i", self.film, *coded, "-t", 4, "-f", "mpegts", self.folder / "first.ts")
        ffmpeg("-ss", 5.5, "-i", self.film, *coded, *second, "-output_ts_offset", 6, "-f", "mpegts", self.folder / "second.ts")
        return self.folder / "first.ts", self.folder / "second.ts"

    def play_with_a_break(self, parts, write, *words, **options):
        """The second part comes once the first was looked at, and after two seconds of silence at least."""
        first = threading.Thread(target=send_unevenly, args=(parts[0], write), daemon=True)
        first.start()
        live = self.live(*words, "--patience", WAIT_S, **options)
        if "stdin" in options:
            os.close(options["stdin"])
        first.join(WAIT_S)
        silent_since, frames = time.monotonic(), frames_of(parts[0])
        held = 10  # the last ones are in libav's buffers until more comes
        self.until(lambda: live.ask("state")["frames"] >= frames - held and time.monotonic() - silent_since > 2)
        send_unevenly(parts[1], write)
        return live

    def expect_both_parts(self, folder, parts):
        """The markers have their names again after the break."""
        live = json.loads((self.folder / folder / "live.json").read_text())
        self.assertEqual(live["frames"], sum(frames_of(part) for part in parts))
        self.assertLess(live["difference"]["rms_px"], 0.1)
        self.expect_place(live["place"], WORN)
        rows = read_table(self.folder / folder / "live_tracks.csv")
        self.assertGreater(max(float(b["time_s"]) - float(a["time_s"]) for a, b in zip(rows, rows[1:])), 1.5)
        for name in NAMES:
            self.assertEqual(rows[-1][name + "_status"], "detected")
        return rows

    def test_a_socket_with_a_break_of_two_seconds(self):
        parts = self.parts()
        server = socket.create_server(("127.0.0.1", 0))
        self.addCleanup(server.close)
        connections = []

        def write(data):
            if not connections:
                connections.append(server.accept()[0])
                self.addCleanup(connections[0].close)
            connections[0].sendall(data)

        live = self.play_with_a_break(parts, write, f"tcp://127.0.0.1:{server.getsockname()[1]}", "-o", "broken")
        connections[0].close()
        code, _, err = live.end()
        self.assertEqual(code, 0, err)
        self.expect_both_parts("broken", parts)

    def test_a_pipe_with_a_break_of_two_seconds_and_another_rate_after_it(self):
        parts = self.parts("-r", 15)
        output, end = os.pipe()
        pipe = os.fdopen(end, "wb", buffering=0)
        self.addCleanup(pipe.close)
        live = self.play_with_a_break(parts, pipe.write, "-", "-o", "halved", stdin=output)
        pipe.close()
        code, _, err = live.end()
        self.assertEqual(code, 0, err)
        rows = self.expect_both_parts("halved", parts)
        for row, interval_s in ((1, 1 / 30), (-1, 1 / 15)):
            self.assertAlmostEqual(float(rows[row]["time_s"]) - float(rows[row - 1]["time_s"]), interval_s, delta=1.1 / 90000)

    def test_curves_and_the_arrow_are_the_truth(self):
        film = self.as_sent("curves")
        state, view = self.watched(film, *self.seeds(), rises=2)
        truth = read_table(self.folder / "worn/truth.csv")
        self.assertEqual((state["is_named"], state["missing"], len(state["rises"])), (True, [], 2))
        self.assertEqual(len(view["samples"]), len(truth))
        for (time_s, knee_deg, *joint_mm), row in zip(view["samples"], truth):
            self.assertAlmostEqual(time_s, float(row["time_s"]), delta=0.0011)  # Matroska's milliseconds
            self.assertAlmostEqual(knee_deg, float(row["knee_deg"]), delta=0.5)
            if None not in joint_mm:  # which way the person looks is not known before the rise
                self.assertLess(math.dist(joint_mm, WORN), 1)
        self.assertEqual(sum(None in joint_mm for _, _, *joint_mm in view["samples"][len(truth) // 2:]), 0)
        # The arrow leads from the joint to the knee.
        for end, name in zip(view["move"], ("exo_knee", "knee")):
            self.assertLess(math.dist(end, [float(truth[-1][f"{name}_{axis}_px"]) for axis in "xy"]), 1)

    def status(self, address, data=None, **how):
        request = urllib.request.Request(address, data, {"Content-Type": "application/json", **how.pop("headers", {})}, **how)
        try:
            with urllib.request.urlopen(request, timeout=WAIT_S) as response:
                return response.status
        except urllib.error.HTTPError as refused:
            with refused:
                return refused.code

    def test_strangers_change_nothing(self):
        """Whatever is sent to it by whom: it is refused, and the session goes on as it was."""
        ffmpeg("-i", self.film, "-c", "copy", self.folder / "asked.ts")
        camera = Camera(self.folder / "asked.ts")
        camera.send()
        live = self.live("-", "-o", "asked", "--patience", WAIT_S, *self.seeds(), stdin=camera.output)
        camera.is_read_by_another()
        before = self.until(lambda: len((now := live.ask("state"))["rises"]) == 2 and now)
        host, token = live.address.split("/")[2:4]
        moved = b'{"what": "moved"}'
        others = token[:-1] + ("1" if token[-1] == "0" else "0")
        for path in ("", others + "/", token[:-1] + "/", token + token + "/"):
            for what, data in (("state", None), ("picture/0.jpg", None), ("view", b'{"after": -1}'), ("act", moved)):
                self.assertEqual(self.status(f"http://{host}/{path}{what}", data), 403, path)
        for headers in ({"Host": "evil.example"}, {"Origin": "http://evil.example"}, {"Origin": "null"}):
            self.assertEqual(self.status(live.address + "act", moved, headers=headers), 403, headers)
        self.assertEqual(self.status(live.address + "act", moved, headers={"Content-Type": "text/plain"}), 415)
        for method, code in (("PUT", 405), ("DELETE", 405), ("PATCH", 405), ("OPTIONS", 405), ("GET", 404)):
            self.assertEqual(self.status(live.address + "act", moved, method=method), code, method)
        self.assertEqual(self.status(live.address + "act", b" " * (2 << 20) + moved), 413)
        for act in (b"", b"moved", b"[]", b"null", b'"moved"', b"[" * 500_000, b"\xff\xfe", b"{}", b'{"what": 1}', b'{"what": "kill"}',
                    b'{"what": "begin"', b'{"what": "name"}', b'{"what": "name", "name": "toe", "x": 1, "y": 1}',
                    b'{"what": "name", "name": "knee", "x": "1", "y": 1}', b'{"what": "name", "name": "knee", "x": 1e308, "y": -1e308}',
                    b'{"what": "name", "name": "knee", "x": null, "y": 1}', b'{"what": "name", "name": "knee", "x": 1e999, "y": 1}'):
            self.assertEqual(self.status(live.address + "act", act), 400, act[:60])
        for view in (b"", b"[]", b"{}", b'{"after": "0"}', b'{"after": null}', b'{"after": 1e300}', b'{"after": 0.5}', b'{"after": 18446744073709551615}', b'{"after": 99999999999999999999}'):
            self.assertEqual(self.status(live.address + "view", view), 400, view)
        for frame in ("", "x.jpg", "-1.jpg", "1e3.jpg", "99999999999999999999.jpg", "123456.jpg", "../../etc/passwd", "0.jpg%00"):
            self.assertIn(self.status(live.address + "picture/" + frame), (400, 403, 404), frame)
        after = live.ask("state")
        for what in ("phase", "moves", "is_named", "rises", "failed"):
            self.assertEqual(after[what], before[what], what)
        live.process.send_signal(signal.SIGINT)
        camera.end()
        self.assertEqual(live.end()[0], 130)
        self.assertEqual(read_table(self.folder / "asked/moves.csv"), [])

    def test_a_disk_without_space_is_a_clear_stop(self):
        """A file system of which 8 MB are to stay free for the trial, and that has room for three quarters of the film."""
        mounted = ["unshare", "--map-root-user", "--mount", "sh", "-c"]
        if subprocess.run([*mounted, "mount -t tmpfs none /mnt"], capture_output=True, check=False).returncode != 0:
            self.skipTest("no file system can be mounted here")
        size = 8_000_000 + self.film.stat().st_size * 3 // 4
        disk = self.folder / "disk"
        disk.mkdir()
        ended = subprocess.run(
            [*mounted, f'mount -t tmpfs -o size={size} none "$0" && {{ "$@" -o "$0/full"; code=$?; cp -r "$0/full" "$0.kept"; exit $code; }}',
             disk, BIN / "lake-live", self.film, "--replay", "--camera", self.camera, "--no-overlay", "--least-free", "8"],
            capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, 1, ended.stderr)
        self.assertIn("the disk is full: less than 8 MB are free; what was recorded until then is a trial", ended.stderr)
        kept = self.folder / "disk.kept"
        self.assertEqual(len(read_table(kept / "live_tracks.csv")), frames_of(kept / "video.mkv"))
        self.assertGreater(len(read_table(kept / "tracks.csv")), 0.4 * self.frames)

    def test_a_full_disk_is_a_clear_stop(self):
        limit = self.film.stat().st_size * 3 // 4
        live = self.live(self.film, "--replay", "-o", "full", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
        code, _, err = live.end()
        self.assertEqual(code, 1)
        self.assertIn("cannot be written further", err)
        self.assertIn("is a trial in full", err)
        self.assertTrue((self.folder / "full/tracks.csv").is_file())
        self.assertGreater(frames_of(self.folder / "full/video.mkv"), 0.4 * self.frames)

    def test_what_was_recorded_outlives_kill_9(self):
        live = self.live(self.film, "--replay", "-o", "killed")
        self.until(lambda: live.ask("state")["recorded_s"] > 5)
        recorded_s = live.ask("state")["recorded_s"]
        live.process.kill()
        live.process.wait(WAIT_S)
        self.assertTrue((self.folder / "killed/video.part.mkv").is_file())
        run(BIN / "lake-live", "killed", cwd=self.folder)
        rows = read_table(self.folder / "killed/tracks.csv")
        self.assertGreater(float(rows[-1]["time_s"]), recorded_s - 1)
        self.assertGreater(float(read_table(self.folder / "killed/live_tracks.csv")[-1]["time_s"]), recorded_s - 1)
        self.assertLess(json.loads((self.folder / "killed/live.json").read_text())["difference"]["rms_px"], 0.1)
        again = subprocess.run([BIN / "lake-live", "killed"], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual((again.returncode, "is a trial already" in again.stderr), (1, True))

    def test_ctrl_c_leaves_a_whole_recording(self):
        opener = self.folder / "opener/xdg-open"
        opener.parent.mkdir()
        opener.write_text(f'#!/bin/sh\necho "$1" >"{self.folder}/opened"\n')
        opener.chmod(0o755)
        live = self.live(self.film, "--replay", "-o", "interrupted", "--open",
                         env=dict(os.environ, PATH=f"{opener.parent}:{os.environ['PATH']}"))
        self.until(lambda: (self.folder / "opened").is_file() and (self.folder / "opened").read_text() == f"{live.address}\n")
        # The film waits, its first picture shown, until the trial begins.
        self.until(lambda: live.ask("state")["frames"] > 0)
        time.sleep(1)
        state = live.ask("state")
        self.assertTrue(state["is_held"])
        self.assertLess(state["recorded_s"], 0.2)
        self.assertFalse(live.ask("act", {"what": "begin"})["is_held"])
        self.until(lambda: live.ask("state")["recorded_s"] > 4)
        live.process.send_signal(signal.SIGINT)
        code, _, err = live.end()
        self.assertEqual(code, 130)
        self.assertIn("lake live interrupted", err)
        self.assertGreater(frames_of(self.folder / "interrupted/video.mkv"), 100)
        run(BIN / "lake-live", "interrupted", cwd=self.folder)
        self.assertTrue((self.folder / "interrupted/kinematics.csv").is_file())

    def test_a_recording_under_way_is_not_finished_by_another(self):
        ffmpeg("-i", self.film, "-c", "copy", self.folder / "under_way.ts")
        camera = Camera(self.folder / "under_way.ts")  # kept open: the session goes on as long as it takes
        camera.send()
        live = self.live("-", "-o", "running", "--patience", WAIT_S, stdin=camera.output)
        camera.is_read_by_another()
        self.until(lambda: live.ask("state")["recorded_s"] > 4)
        for words, code, text in ((("running",), 1, "another run is at work"),
                                  (("running", "-o", "elsewhere"), 2, "-o")):
            other = subprocess.run([BIN / "lake-live", *words], cwd=self.folder, capture_output=True, text=True, check=False)
            self.assertEqual(other.returncode, code, other.stderr)
            self.assertIn(text, other.stderr)
        self.assertTrue((self.folder / "running/video.part.mkv").is_file())
        live.process.send_signal(signal.SIGINT)
        code, _, err = live.end()
        camera.end()
        self.assertEqual(code, 130, err)
        self.assertIn("lake live", err)
        run(BIN / "lake-live", "running", cwd=self.folder)
        self.assertTrue((self.folder / "running/tracks.csv").is_file())

    def test_a_seed_that_points_at_nothing_costs_no_recording(self):
        film = self.folder / "first_rise.mp4"
        ffmpeg("-i", self.film, "-c", "copy", "-t", 5, film)
        frames = frames_of(film)
        code, _, err = self.live(film, "--replay", "-o", "missed", "--seed=exo_knee=5,5", "--tolerance", 1).end()
        self.assertEqual(frames_of(self.folder / "missed/video.mkv"), frames, err)
        self.assertEqual(len(read_table(self.folder / "missed/live_tracks.csv")), frames)
        self.assertIn("--tolerance 1 mm", err)  # below what any number of rises tells
        self.assertEqual(code, 1, err)  # lake track is told of the joint's marker by no one
        self.assertIn("the recording is whole", err)

    def test_errors_say_what_to_do(self):
        for words, code, text in (((self.film,), 2, "--replay"), (("absent.mp4",), 1, "no such device or file"),
                                  ((self.film, "--replay", "--markers", "ankle,knee,hip"), 2, "--joint exo_knee"),
                                  ((self.film, "--replay", "--joint", "hip"), 2, "--joint hip"),
                                  ((self.film, "--replay", "--seed", "toe=1,1"), 2, "--seed toe")):
            ended = subprocess.run([str(word) for word in (BIN / "lake-live", *words, "--camera", self.camera, "-o", "wrong")],
                                   cwd=self.folder, capture_output=True, text=True, check=False)
            self.assertEqual(ended.returncode, code, ended.stderr)
            self.assertIn(text, ended.stderr)
            self.assertEqual(len(ended.stderr.splitlines()), 1)


class LongStreams(Films):
    def test_the_sample_study(self):
        """Three rises at 60 Hz: the recording is the exoskeleton's in a study as well as a trial to be compared."""
        code, _, err = self.live(SAMPLE / "exo.mp4", "--replay", "-o", "sample", camera=SAMPLE / "camera.yaml").end()
        self.assertEqual(code, 0, err)
        live = self.expect_trial(self.folder / "sample", frames_of(SAMPLE / "exo.mp4"), 3)
        self.assertLess(math.dist(live["place"]["offset_mm"], WORN), 1)
        self.assertLess(live["difference"]["largest_px"], 0.1)
        study = {"camera": str(SAMPLE / "camera.yaml"), "human": {"video": str(SAMPLE / "human.mp4")},
                 "exo": {"video": "sample/video.mkv", "overlay": False, "markers": NAMES,
                         "seeds": ["knee=728,431@0", "exo_knee=740,415@0"]},
                 "compare": {"exo_knee": "exo_knee"}, "simulate": {"animation": False}}
        (self.folder / "study.yaml").write_text(json.dumps(study))
        run(BIN / "lake-run", "study.yaml", "-o", "study", cwd=self.folder)
        joint = json.loads((self.folder / "study/comparison/comparison.json").read_text())["joint"]
        self.assertLess(math.dist(joint["offset_mm"], live["place"]["offset_mm"]), 0.5)

    def expect_verdicts(self, name, wrong, *words, film=None, apart=""):
        """Those of lake check, of which these are not good; `apart` is not looked at."""
        sent = self.as_sent(name, "-t", 4, *words, film=film)
        state, _ = self.watched(sent)
        checked = subprocess.run([BIN / "lake-check", sent, "--json", "-o", self.folder / f"{name}.checked"], capture_output=True,
                                 text=True, check=False)
        self.assertIn(checked.returncode, (0, 1), checked.stderr)
        known = {item["name"]: item["verdict"] for item in json.loads(checked.stdout)["checks"]}
        self.assertEqual(len(state["checks"]), len(JUDGED))
        told = {figure: check for figure, check in zip(JUDGED, state["checks"]) if figure != apart}
        self.assertEqual({figure: check["verdict"] for figure, check in told.items()}, {figure: known[figure] for figure in told})
        for figure, check in told.items():
            if figure != "blur_px":  # at 30 Hz it is near its limit, on either side
                self.assertEqual(check["verdict"] != "good", figure in (*wrong, "frame_rate_hz"), check)  # 30 Hz is poor
            self.assertEqual(check["advice"] == "", check["verdict"] == "good")

    def test_verdicts_are_those_of_lake_check(self):
        grey = "lutyuv=y='clip(16+(val-16)*{},16,235)'"
        overexposed = "format={},lutyuv=y='if(gt(val,120),min({},120+(val-120)*{}),val)'"
        for name, wrong, words in (
                ("fit", (), ()),
                ("dark", ("contrast_over_noise",), ("-vf", grey.format(0.7) + ",noise=c0s=12:c0f=t")),
                ("small", ("radius_px",), ("-vf", "scale=iw/2:-1")),
                ("repeating", ("repeated_frames",), ("-vf", "fps=28,fps=30")),
                ("gaps", ("dropped_frames",), ("-vf", "select='mod(n,20)'", "-vsync", "passthrough"))):
            with self.subTest(name):
                self.expect_verdicts(name, wrong, *words)
        # Coding with loss blurs the level at which it is clipped; what it makes of three times the noise is not fit any more.
        for coding, form, white, gain, words in (
                ("ffv1", "gray", 255, 3, ()),
                ("mjpeg", "yuvj420p", 255, 1.7, ("-q:v", 5)),
                ("libx264", "yuv420p", 235, 1.7, ("-crf", 23, "-bf", 0, "-g", 15))):
            made = ("-vf", overexposed.format(form, white, gain), "-c:v", coding, "-pix_fmt", form, *words)
            with self.subTest("overexposed", coding=coding):
                # The spots of knee and joint, grown, touch in many frames; lake check then looks on in more of them than a session.
                self.expect_verdicts(f"overexposed_{coding}", ("saturated_share",), *made, apart="all_seen_share")


@unittest.skipIf(DRIVER is None, "no chromedriver and selenium for this Python "
                 "(Debian packages chromium-driver and python3-selenium)")
class Browser(PageParts, Films):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser = headless(1400, 1250, cls.folder / "profile")
        cls.addClassCleanup(cls.browser.quit)

    def shot(self, name):
        if folder := os.environ.get("LAKE_SHOTS"):
            self.browser.save_screenshot(str(pathlib.Path(folder) / f"{name}.png"))


class Page(Browser):
    """A session in the browser: two rises, the joint moved, two rises, a trial."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        # One film: the person sits without sway where the two meet, and only the joint's marker is elsewhere.
        one = cls.folder / "before/camera.yaml"
        for name, place, camera in (("before", WORN, ()), ("moved", MOVED, ("--camera", one))):
            synth(cls.folder / name, (place[0] + MARKER_AT[0], place[1] + MARKER_AT[1]), "--still", *camera)
        films = [cls.folder / "before/video.mp4", cls.folder / "moved/video.mp4"]
        (cls.folder / "films.txt").write_text("".join(f"file '{film}'\n" for film in films))
        ffmpeg("-f", "concat", "-safe", 0, "-i", cls.folder / "films.txt", "-c", "copy", cls.folder / "session.ts")
        ffmpeg("-i", cls.film, "-c", "copy", cls.folder / "film.ts")
        cls.before_s = frames_of(films[0]) / 30

    def test_a_session(self):
        camera = Camera(self.folder / "session.ts")
        camera.send(camera.at(0.8))  # the person sits still
        live = self.live("-", "--tolerance", 6, "--joint-at", "0,-60", "--patience", WAIT_S, "-o", "session", stdin=camera.output)
        camera.is_read_by_another()
        self.browser.get(live.address)
        self.until(lambda: self.text("live-trial") == "Begin trial")
        self.until(lambda: self.part("live-picture").get_attribute("data-frame"))
        # Before the start: what is wrong with the pictures, and who has no name yet.
        for name in NAMES:
            self.assertIn(name, self.text("live-naming"))
        self.until(lambda: "poor: 30 frames/s" in self.text("live-checks"))
        self.assertEqual(self.text("live-check-count"), "Pictures: 1 change needed")
        self.click_marker("exo_knee", read_table(self.folder / "before/truth.csv")[0])
        self.shot("begin")
        self.assertFalse(self.part("live-sound").is_selected())
        self.part("live-sound").click()
        rung = self.until(lambda: int(self.part("live-sound").get_attribute("data-rung") or 0))
        self.part("name").click()  # the focus is the page's
        ActionChains(self.browser).send_keys(" ").perform()
        self.until(lambda: self.text("live-trial") == "End trial")
        camera.send(camera.at(self.before_s))
        self.until(lambda: len(live.ask("state")["rises"]) == 2)
        self.until(lambda: re.fullmatch(self.MOVE, self.text("live-move")))
        self.assertEqual(self.part("live-place").get_attribute("class"), "beyond")
        self.assertEqual(self.text("live-verdict"), "✗ Not within 6 mm")  # in words, not by a colour alone
        self.assertEqual(int(self.part("live-sound").get_attribute("data-rung")), rung)
        self.shot("rise")
        for width in (800, 1400):
            self.browser.set_window_size(width, 1250)
            for text in ("live-move", "live-verdict"):
                self.assertGreaterEqual(self.capital_px(text), LETTER_PX, (text, width))
            self.shot(f"rise-{width}")
        self.until(lambda: live.ask("state")["recorded_s"] > self.before_s - 0.3)
        ActionChains(self.browser).send_keys("m").perform()  # the person sits; the joint is moved
        self.until(lambda: "Move 1 noted" in self.text("said"))
        camera.send()
        self.until(lambda: len(live.ask("state")["rises"]) == 4)
        self.expect_place(live.ask("state")["place"], MOVED)
        self.until(lambda: "nearer to the knee than before the last move" in self.text("live-change"))
        self.assertEqual(self.part("live-place").get_attribute("class"), "within")
        self.assertEqual(self.text("live-verdict"), "✓ Within 6 mm")
        self.assertGreater(int(self.part("live-sound").get_attribute("data-rung")), rung)
        self.shot("moved")
        camera.end()
        state = self.until(lambda: (now := live.ask("state"))["phase"] in ("done", "failed") and now)
        self.assertEqual(state["failed"], "")
        self.until(lambda: "differ from the trial" in self.text("live-difference"))
        self.shot("done")
        log = [line for line in self.browser.get_log("browser") if line["level"] == "SEVERE" and "picture/" not in line["message"]]
        self.assertEqual(log, [])
        self.browser.get("about:blank")  # the last window closes, and the program ends
        code, out, err = live.end()
        self.assertEqual(code, 0, err)
        moves = read_table(self.folder / "session/moves.csv")
        self.assertEqual([row["move"] for row in moves], ["1"])
        rises = read_table(self.folder / "session/rises.csv")
        self.assertEqual([row["moves"] for row in rises], ["0", "0", "1", "1"])
        # The trial tells of the same joint, and is what was recorded since the move.
        run(BIN / "lake-compare", "session", "session", "--exo-knee", "exo_knee", "--joint-at", "0,-60", "-o", "compared", cwd=self.folder)
        joint = json.loads((self.folder / "compared/comparison.json").read_text())["joint"]
        self.assertLess(math.dist(joint["offset_mm"], MOVED), 1)
        start_s = float(read_table(self.folder / "session/tracks.csv")[0]["time_s"])
        self.assertGreaterEqual(start_s, float(moves[0]["time_s"]) - 0.001)

    def capital_px(self, name):
        return self.browser.execute_script(
            "const letter = document.createElement('canvas').getContext('2d');"
            "letter.font = getComputedStyle(arguments[0]).font;"
            "return letter.measureText('M').actualBoundingBoxAscent", self.part(name))

    def click_marker(self, name, truth):
        """As a person does where it must ask: the name, then its spot."""
        picture = self.part("live-picture")
        scale = picture.rect["width"] / 1280
        for button in self.part("live-names").find_elements(By.TAG_NAME, "button"):
            if button.text == name:
                button.click()
        away = [(float(truth[f"{name}_{axis}_px"]) + 0.5) * scale - size / 2
                for axis, size in (("x", picture.rect["width"]), ("y", picture.rect["height"]))]
        ActionChains(self.browser).move_to_element_with_offset(picture, *away).click().perform()
        self.until(lambda: self.text("said") == f"{name} named")

    def test_a_marker_is_named_by_a_click_and_a_trial_ended_by_a_button(self):
        camera = Camera(self.folder / "film.ts")
        camera.send(camera.at(0.8))
        live = self.live("-", "--patience", WAIT_S, "-o", "clicked", stdin=camera.output)
        camera.is_read_by_another()
        self.browser.get(live.address)
        self.until(lambda: self.part("live-picture").get_attribute("data-frame"))
        self.click_marker("exo_knee", read_table(self.folder / "worn/truth.csv")[0])  # seated, the joint rests
        self.part("live-trial").click()
        self.until(lambda: self.text("live-trial") == "End trial")
        self.part("live-moved").click()
        self.until(lambda: "Move 1 noted" in self.text("said"))
        # Nothing is lost while the page is closed, and it is as it was when it is opened again.
        self.browser.get("about:blank")
        camera.send()
        self.until(lambda: len(live.ask("state")["rises"]) == 2)
        self.browser.get(live.address)
        self.until(lambda: self.text("live-rise-count") == "2 rises")
        self.assertEqual(self.text("live-trial"), "End trial")
        self.part("live-trial").click()
        state = self.until(lambda: (now := live.ask("state"))["phase"] in ("done", "failed") and now)
        self.assertEqual(state["failed"], "")
        self.assertIn("it was stopped", state["end"])
        self.browser.get("about:blank")
        code, _, err = live.end()
        self.assertEqual(code, 0, err)
        self.expect_place(json.loads((self.folder / "clicked/live.json").read_text())["place"], WORN)
        self.assertEqual(len(read_table(self.folder / "clicked/moves.csv")), 1)
        self.assertTrue((self.folder / "clicked/kinematics.csv").is_file())


if __name__ == "__main__":
    unittest.main()
