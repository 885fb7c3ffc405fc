"""lake review as a person uses it: the built program, a rendered recording, headless Chromium.

One browser and one recording serve all tests. LAKE_BIN: where the programs are."""
import csv
import json
import os
import pathlib
import re
import resource
import shlex
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.request

try:
    from browser import DRIVER, PageParts, headless
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.ui import Select
except ImportError:
    DRIVER, PageParts = None, object

BIN = pathlib.Path(os.environ.get("LAKE_BIN", "build/test/bin")).resolve()
WAIT_S = 60  # a loaded machine; what is waited for takes a second
SIZE = (1280, 720)  # of the recording, px
# lake track needs to be told: a hand hides knee and hip at once, and before and after it the leg bends too little.
SEEDS = {"ankle": 0, "knee": 0, "hip": 0, "waist": 0}  # their candidates' numbers, which the release of OpenCV decides


# With the limits of calibration/problems/buildable.yaml.
PROBLEM = """standing_deg: 5
margins: {grashof_mm: 2, singularity_mm: 2}
load: {knee_torque_nm: 40, max_force_n: 2000}
min_transmission_deg: 10
"""


# Of a study: the linkage moving, which no test here looks at, is most of a simulation's time.
NO_ANIMATION = "simulate: {animation: false}\n"


# What of the page's text, but for what cannot be used now, has too little contrast with its ground, is small or cut off.
HARD_TO_READ = """
const linear = c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
const channels = text => text.match(/[\\d.]+/g).map(Number);
const light = ([r, g, b]) => 0.2126 * linear(r / 255) + 0.7152 * linear(g / 255) + 0.0722 * linear(b / 255) + 0.05;
const ground = part => {
  for (; part; part = part.parentElement) {
    const colour = channels(getComputedStyle(part).backgroundColor);
    if (colour.length < 4 || colour[3] > 0) return colour;
  }
};
return [...document.querySelectorAll("body *")].filter(part => {
  const words = [...part.childNodes].some(child => child.nodeType === Node.TEXT_NODE && child.data.trim());
  if (!words || part.closest("script, style, select") || part.disabled || !part.getClientRects().length) return false;
  const style = getComputedStyle(part), lights = [light(channels(style.color)), light(ground(part))];
  return Math.max(...lights) / Math.min(...lights) < 4.5 || parseFloat(style.fontSize) < 12 ||
    (style.textOverflow === "ellipsis" && part.scrollWidth > part.clientWidth);
}).map(part => `${part.tagName}: ${part.textContent}`);
"""


def run(*words, files=None, **options):
    for path, text in (files or {}).items():
        path.write_text(text)
    return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True, **options)


def read_table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


class Review:
    """The program at work; its page's address once it has said it."""

    def __init__(self, folder, subject, *options):
        self.process = subprocess.Popen(
            [BIN / "lake-review", subject, *options], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True, restore_signals=False)  # a file beyond its limit is an error, as on a full disk, not the end
        self.address = self.process.stdout.readline().strip()

    def ask(self, path, message=None, **headers):
        data = None if message is None else json.dumps(message).encode()
        request = urllib.request.Request(self.address + path, data, {"Content-Type": "application/json", **headers})
        with urllib.request.urlopen(request, timeout=WAIT_S) as response:
            return json.load(response)

    def end(self, sign=signal.SIGINT):
        self.process.send_signal(sign)
        return self.wait()

    def close(self, sign=signal.SIGTERM):
        self.process.send_signal(sign)
        self.process.wait(WAIT_S)
        self.process.stdout.close()
        self.process.stderr.close()

    def wait(self):
        err = self.process.communicate(timeout=WAIT_S)[1]
        return self.process.returncode, err


@unittest.skipIf(DRIVER is None, "no chromedriver and selenium for this Python "
                 "(Debian packages chromium-driver and python3-selenium)")
class ReviewPage(PageParts, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="lake-test-")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        run(BIN / "lake-synth", "--duration", 4, "--rate", 30, "--seed-number", 31, "--crf", 23, "--hide", "knee=1.6,0.3",
            "--hide", "hip=1.6,0.3", "--quiet", "-o", cls.folder / "recording")
        run(BIN / "lake-track", "recording/video.mp4", "--list", "--quiet", "-o", "listed", cwd=cls.folder)
        candidates, truth = read_table(cls.folder / "listed/candidates.csv"), read_table(cls.folder / "recording/truth.csv")
        for name in SEEDS:
            SEEDS[name] = int(min(candidates, key=lambda candidate: sum(
                abs(float(candidate[f"{axis}_px"]) - float(truth[int(candidate["frame"])][f"{name}_{axis}_px"])) for axis in "xy"))["id"])
        run(BIN / "lake-track", "recording/video.mp4", "--camera", "recording/camera.yaml", "--no-overlay", "--quiet",
            "-o", "trial", *[f"--seed={name}=#{spot}" for name, spot in SEEDS.items()], cwd=cls.folder)
        run(BIN / "lake-optimize", "--problem", "problem.yaml", "--starts", 1, "--quiet", "-o", "optimum", cwd=cls.folder,
            files={cls.folder / "problem.yaml": PROBLEM})
        cls.browser = headless(1300, 1100, cls.folder / "profile")
        cls.addClassCleanup(cls.browser.quit)

    def setUp(self):
        self.trial = self.folder / self.id().rsplit(".", 1)[1]

    def tearDown(self):
        log = [line for line in self.browser.get_log("browser") if line["level"] == "SEVERE"]
        self.browser.get("about:blank")
        self.assertEqual(log, [])

    def forget_unanswered(self):
        """That nobody answers any more is on the console too, once more with each question that the page still asks."""
        self.browser.get("about:blank")
        self.browser.get_log("browser")

    def copy_trial(self):
        shutil.copytree(self.folder / "trial", self.trial)
        return self.trial

    def start(self, subject, *options):
        review = Review(self.folder, subject, *options)
        self.addCleanup(review.close)
        return review

    def open(self, subject):
        review = self.start(subject)
        self.browser.get(review.address)
        return review

    def open_trial(self):
        review = self.open(self.copy_trial())
        self.until(lambda: self.frame() == 0)
        return review

    # What the page shows

    def until(self, condition, what=None):
        self.wait_until(condition, WAIT_S, what or (lambda: f"{self.text('state')} {self.text('said')}"))

    def hold_a_state_until_answered(self, question):
        """On a busy machine the answer of a poll arrives after that of a later question."""
        self.browser.execute_script("""
            const ask = window.fetch;
            let release;
            const answered = new Promise((resolve) => { release = resolve; });
            window.fetch = async (path, ...rest) => {
              const answer = await ask(path, ...rest);
              if (path === arguments[0]) release();
              if (path === "state" && !window.isHeld) {
                window.isHeld = true;
                await answered;
                await new Promise((resolve) => setTimeout(resolve, 50));
              }
              return answer;
            };""", question)
        self.until(lambda: self.browser.execute_script("return window.isHeld === true"))

    def answer_late(self, question):
        """On a busy machine an answer arrives after what the person did meanwhile."""
        self.browser.execute_script("""
            const ask = window.fetch;
            window.fetch = async (path, ...rest) => {
              const answer = await ask(path, ...rest);
              if (path === arguments[0]) await new Promise((resolve) => setTimeout(resolve, 500));
              return answer;
            };""", question)

    def frame(self):
        number = self.part("frame").get_attribute("data-frame")
        return None if number is None else int(number)

    def marker(self, name):
        return self.browser.execute_script(
            "const m = document.querySelector(`#markers [data-marker=${arguments[0]}]`); return m && {...m.dataset}",
            name) or {}

    def status(self, name):
        return self.marker(name).get("status")

    def is_corrected(self, name):
        return self.marker(name).get("corrected") == "true"

    # What a person does

    def press(self, *keys, holding=None):
        chain = ActionChains(self.browser)
        if holding:
            chain.key_down(holding)
        chain.send_keys(*keys)
        if holding:
            chain.key_up(holding)
        chain.perform()

    def seek(self, frame):
        self.browser.execute_script(
            "const s = arguments[0]; s.value = arguments[1]; s.dispatchEvent(new Event('input'))", self.part("scrub"),
            frame)
        self.until(lambda: self.frame() == frame)

    def on_screen(self, canvas, x, y):
        """Where a place of the picture is, from the canvas's middle."""
        box = self.part(canvas).rect
        scale = min(box["width"] / SIZE[0], box["height"] / SIZE[1])
        return round((x - (SIZE[0] - 1) / 2) * scale), round((y - (SIZE[1] - 1) / 2) * scale), scale

    def drag(self, start, by, holding=None):
        x, y, _ = self.on_screen("picture", *start)
        chain = ActionChains(self.browser, duration=20)
        if holding:
            chain.key_down(holding)
        chain.move_to_element_with_offset(self.part("picture"), x, y).click_and_hold()
        chain.move_by_offset(*by).release()
        if holding:
            chain.key_up(holding)
        chain.perform()

    def place(self, name, frame, folder=None):
        row = read_table((folder or self.folder / "trial") / "tracks.csv")[frame]
        return float(row[f"{name}_x_px"]), float(row[f"{name}_y_px"])

    def vanishes(self, name):
        """The frame in which the hand hides a marker."""
        rows = read_table(self.folder / "trial/tracks.csv")
        return next(i for i, row in enumerate(rows) if i > 40 and row[f"{name}_status"] != "detected")

    def comes_back(self, name):
        rows = read_table(self.folder / "trial/tracks.csv")
        return next(i for i, row in enumerate(rows) if i > self.vanishes(name) and row[f"{name}_status"] == "detected")

    def corrections(self):
        path = self.trial / "corrections.csv"
        return read_table(path) if path.exists() else []

    # Tests

    def test_goes_through_frames_and_problems(self):
        self.open_trial()
        self.press(Keys.ARROW_RIGHT)
        self.until(lambda: self.frame() == 1)
        self.press(Keys.ARROW_RIGHT, holding=Keys.SHIFT)
        self.until(lambda: self.frame() == 11)
        self.press(Keys.ARROW_LEFT)
        self.until(lambda: self.frame() == 10)
        hidden_from = self.vanishes("knee")
        while f"knee not seen, frames {hidden_from} to" not in self.text("said"):
            self.press("]")
            self.assertNotIn("no further problem", self.text("said"))
        self.until(lambda: self.frame() == hidden_from)
        self.assertEqual((self.status("knee"), self.status("ankle")), ("filled", "detected"))
        self.seek(0)
        self.press("[")
        self.assertIn("no further problem", self.text("said"))
        self.seek(hidden_from)
        self.press(" ")
        self.until(lambda: self.frame() > hidden_from + 2)
        self.press(" ")
        elsewhere = self.browser.execute_script(
            "return performance.getEntriesByType('resource').map(e => e.name).filter(n => !n.startsWith(location.href))")
        self.assertEqual(elsewhere, [], "fetched from elsewhere")

    def test_goes_to_a_frame_by_its_number_and_plays_to_the_end(self):
        self.open_trial()
        self.press("g")
        self.press("25", Keys.ENTER)
        self.until(lambda: self.frame() == 25)
        go_to = self.part("go-to")
        go_to.clear()
        go_to.send_keys("99999", Keys.ENTER)
        last = len(read_table(self.folder / "trial/tracks.csv")) - 1
        self.until(lambda: f"99999: frames 0 to {last} are there" in self.text("said"))
        self.assertEqual(self.frame(), 25)
        self.seek(last - 20)
        Select(self.part("speed")).select_by_visible_text("0.5 × real time")
        self.part("play").click()
        self.until(lambda: self.frame() == last and self.part("play").text == "Play")

    def test_drags_snaps_and_takes_back(self):
        review = self.open_trial()
        self.seek(20)
        ankle = self.place("ankle", 20)
        self.drag(ankle, (7, -5))
        self.until(lambda: "ankle snapped" in self.text("said"))
        row, = self.corrections()
        self.assertEqual((row["frame"], row["marker"]), ("20", "ankle"))
        # The same spot, found in one picture alone: within the noise of a marker there.
        self.assertLess(abs(float(row["x_px"]) - ankle[0]) + abs(float(row["y_px"]) - ankle[1]), 0.3)
        self.drag(ankle, (30, 0), holding=Keys.ALT)
        self.until(lambda: "± 0.5 px" in self.text("said"))
        row, = self.corrections()
        self.assertAlmostEqual(float(row["x_px"]), ankle[0] + 30 / self.on_screen("picture", 0, 0)[2], delta=2)
        self.assertEqual(float(row["sigma_px"]), 0.5)
        self.until(lambda: "1 correction, saved" in self.text("state"), "not fitted anew")
        self.part("undo").click()
        self.press("z", holding=Keys.CONTROL)
        self.until(lambda: self.text("state") == "No corrections")
        self.assertEqual(self.corrections(), [])
        self.press("y", holding=Keys.CONTROL)
        self.until(lambda: self.is_corrected("ankle"))
        self.assertEqual(len(self.corrections()), 1)
        review.close(signal.SIGKILL)  # nothing of what was saved is lost
        self.until(lambda: "lake review has ended" in self.text("said"))
        review = self.open(self.trial)
        self.until(lambda: self.text("state") == "1 correction, saved")
        self.part("undo").click()
        self.part("undo").click()
        self.until(lambda: self.text("state") == "No corrections")
        self.press("y", holding=Keys.CONTROL)
        self.until(lambda: self.text("state") == "1 correction, saved")
        self.assertEqual(len(self.corrections()), 1)
        self.assertEqual(review.end(), (130, "lake-review: interrupted\n"))
        self.until(lambda: "lake review has ended" in self.text("said"))
        self.forget_unanswered()

    def test_hides_places_and_restores(self):
        self.open_trial()
        self.seek(30)
        self.press("2", "h")
        self.until(lambda: self.status("knee") == "filled" and self.is_corrected("knee"))
        x, y, _ = self.on_screen("picture", *self.place("knee", 30))
        self.press("a")
        ActionChains(self.browser).move_to_element_with_offset(self.part("picture"), x + 3, y).click().perform()
        self.until(lambda: self.status("knee") == "detected")
        self.press("r")
        self.until(lambda: not self.is_corrected("knee"))
        self.press(Keys.ARROW_UP, holding=Keys.ALT)
        self.until(lambda: self.is_corrected("knee"))
        self.assertEqual(len(self.corrections()), 1)
        Select(self.part("swap-with")).select_by_value("hip")
        self.part("frame").click()
        self.press("x")
        self.until(lambda: "knee and hip swapped from frame 30 on" in self.text("said"))
        self.assertEqual({row["marker"] for row in self.corrections()}, {"knee", "hip"})

    def test_zooms_to_a_marker_and_pans(self):
        self.open_trial()
        self.seek(20)
        knee, (_, _, scale) = self.place("knee", 20), self.on_screen("picture", 0, 0)
        self.press("2", "+")  # the knee in the middle, four times as large
        self.drag_from_middle((0, 0), (40, 0), holding=Keys.ALT)
        self.until(lambda: self.is_corrected("knee"))
        row, = self.corrections()
        self.assertAlmostEqual(float(row["x_px"]), knee[0] + 40 / (4 * scale), delta=2 / (4 * scale))
        self.press("r")
        self.until(lambda: not self.is_corrected("knee"))
        self.drag_from_middle((0, 120), (-60, 30))  # nothing is there to be moved but the picture
        self.drag_from_middle((-60, 30), (0, -40), holding=Keys.ALT)
        self.until(lambda: self.is_corrected("knee"))
        row, = self.corrections()
        self.assertAlmostEqual(float(row["y_px"]), knee[1] - 40 / (4 * scale), delta=2 / (4 * scale))
        self.press("r", "0")
        self.until(lambda: not self.is_corrected("knee"))
        self.drag(knee, (0, 25), holding=Keys.ALT)  # the whole picture again
        self.until(lambda: self.is_corrected("knee"))
        self.assertAlmostEqual(float(self.corrections()[0]["y_px"]), knee[1] + 25 / scale, delta=2 / scale)

    def drag_from_middle(self, start, by, holding=None):
        chain = ActionChains(self.browser, duration=20)
        if holding:
            chain.key_down(holding)
        chain.move_to_element_with_offset(self.part("picture"), *start).click_and_hold().move_by_offset(*by).release()
        if holding:
            chain.key_up(holding)
        chain.perform()

    def test_a_full_disk_is_told_and_nothing_is_lost(self):
        review = self.open_trial()
        self.press("1", "h")
        self.until(lambda: self.is_corrected("ankle"))
        saved = (self.trial / "corrections.csv").read_bytes()
        limits = resource.prlimit(review.process.pid, resource.RLIMIT_FSIZE)
        resource.prlimit(review.process.pid, resource.RLIMIT_FSIZE, (10, limits[1]))
        self.press("2", "h")
        self.until(lambda: "review.json" in self.text("said"))
        self.assertFalse(self.is_corrected("knee"), "is shown though it is not saved")
        self.assertEqual((self.trial / "corrections.csv").read_bytes(), saved)
        resource.prlimit(review.process.pid, resource.RLIMIT_FSIZE, limits)
        self.press("h")
        self.until(lambda: self.is_corrected("knee"))
        self.assertEqual(len(self.corrections()), 2)
        self.browser.get_log("browser")  # that it was refused is on the console too

    def events(self, name="events_corrected.csv"):
        """Frames by (repetition, event)."""
        return {(int(row["repetition"]), row["event"]): int(row["frame"]) for row in read_table(self.trial / name)}

    def drag_event(self, frame, to):
        """On the timeline, by its circle; what is left of the frames' axis is the markers' names."""
        canvas = self.part("timeline")
        self.browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", canvas)
        rows, width, height = len(read_table(self.trial / "tracks.csv")), canvas.rect["width"], canvas.rect["height"]
        x = lambda row: round(46 + row / (rows - 1) * (width - 52) - width / 2)
        ActionChains(self.browser, duration=20).move_to_element_with_offset(
            canvas, x(frame), round(height / 2) - 24).click_and_hold().move_by_offset(
            x(to) - x(frame), 0).release().perform()

    def test_an_event_is_moved(self):
        self.open_trial()
        self.until(lambda: self.text("state") == "No corrections")
        found = self.events("events.csv")
        onset, seat_off, standing = (found[1, name] for name in ("onset", "seat_off", "standing"))
        self.assertNotIn("--events", self.text("command"))
        # By keys: the second event, three frames later.
        self.press("e", "e")
        self.until(lambda: self.frame() == seat_off)
        for step in (1, 2, 3):
            self.press(Keys.ARROW_RIGHT)
            self.until(lambda: self.frame() == seat_off + step)
        self.press("m")
        self.until(lambda: f"seat-off 1 moved to frame {seat_off + 3}" in self.text("said"))
        self.assertEqual(self.events(), {(1, "seat_off"): seat_off + 3})
        self.assertTrue(self.part("event-restore").is_enabled())
        # By mouse.
        self.drag_event(standing, standing - 8)
        self.until(lambda: "standing 1 moved to frame" in self.text("said"))
        dragged = self.events()[1, "standing"]
        self.assertLess(abs(dragged - (standing - 8)), 2)
        self.drag_event(onset, standing + 10)
        self.until(lambda: "is before onset of repetition 1" in self.text("said"))
        self.browser.get_log("browser")  # that it was refused is on the console too
        self.assertEqual(self.events(), {(1, "seat_off"): seat_off + 3, (1, "standing"): dragged})
        self.part("undo").click()
        self.until(lambda: (1, "standing") not in self.events())
        self.press("y", holding=Keys.CONTROL)
        self.until(lambda: (1, "standing") in self.events())
        self.browser.find_element(By.CSS_SELECTOR, "#events [data-event='seat_off 1']").click()
        self.part("event-restore").click()
        self.until(lambda: self.events() == {(1, "standing"): dragged})
        self.until(lambda: "--events" in self.text("command"))
        run(BIN / "lake", *shlex.split(self.text("command"))[1:], "--quiet", cwd=self.folder)
        self.assertEqual(self.events("events.csv"), {**found, (1, "standing"): dragged})

    def test_timeline_and_curves_share_one_time_axis(self):
        self.open_trial()
        self.until(lambda: "knee" in self.text("frame"))
        self.assertRegex(self.text("frame"), r"^Frame 0 of 119, 0\.000 s, knee \d+\.\d° ± \d+\.\d\d°$")
        sides = {(box["x"], box["width"]) for box in
                 (self.part(name).rect for name in ("timeline", "knee-chart", "lengths-chart", "residuals-chart"))}
        self.assertEqual(len(sides), 1, "an event does not stand over its curve")

    def measured(self, name):
        return self.browser.execute_script(
            "const m = document.querySelector(`#measures [data-measure=${arguments[0]}] h2`); return m && m.textContent",
            name)

    def measure(self, kind, *markers):
        Select(self.part("measure-kind")).select_by_value(kind)
        for which, marker in zip(("first", "second", "third"), markers):
            Select(self.part(f"measure-{which}")).select_by_value(marker)
        self.part("measure").click()

    def test_angles_distances_and_speeds_of_any_markers(self):
        self.open_trial()
        self.measure("angle", "ankle", "knee", "hip")
        self.measure("distance", "ankle", "waist")
        self.measure("speed", "hip")
        name = "ankle_knee_hip_angle"
        self.until(lambda: self.measured(name) and self.measured("hip_speed"))
        # The same words to lake track give the same numbers.
        words = shlex.split(self.text("command"))[1:]
        self.assertEqual(words[-6:], ["--angle", f"{name}=ankle,knee,hip", "--distance",
                                      "ankle_waist_distance=ankle,waist", "--speed", "hip_speed=hip"])
        words[words.index("-o") + 1] = self.folder / "measured"
        corrections = words.index("--corrections")  # of which there are none yet
        del words[corrections:corrections + 2]
        run(BIN / "lake-track", *words[1:], "--quiet", "--no-overlay", cwd=self.folder)
        table = read_table(self.folder / "measured" / "measures.csv")
        for frame in (0, 80):
            self.seek(frame)
            row = table[frame]
            for shown, column, digits in ((name, f"{name}_deg", 1), ("ankle_waist_distance", "ankle_waist_distance_mm", 1),
                                          ("hip_speed", "hip_speed_mm_s", 1)):
                value = float(self.measured(shown).split(": ")[1].split("±")[0].split()[0].rstrip("°"))
                self.assertAlmostEqual(value, float(row[column]), delta=0.51 * 10 ** -digits + 1e-4)  # as rounded
        # Of a marker that is hidden nothing is measured; what was asked stays in the address.
        self.press("2", "h")
        self.until(lambda: "not seen here" in self.measured(name))
        self.assertNotIn("not seen here", self.measured("hip_speed"))
        self.browser.refresh()
        self.until(lambda: self.frame() == 0 and self.measured("hip_speed"))
        self.browser.find_element(By.CSS_SELECTOR, f"[aria-label='Remove {name}']").click()
        self.until(lambda: not self.measured(name))
        self.assertNotIn("--angle", self.text("command"))

    def test_controls_handle_their_own_keys(self):
        self.open_trial()
        keys = self.browser.find_element(By.CSS_SELECTOR, ".foot summary")
        is_open = lambda: keys.find_element(By.XPATH, "..").get_attribute("open") is not None
        for key, opened in ((Keys.ENTER, True), (Keys.SPACE, False)):
            keys.send_keys(key)
            self.assertEqual(is_open(), opened)
        picture = lambda: self.browser.execute_script("return arguments[0].toDataURL()", self.part("picture"))
        whole = picture()
        self.part("zoom-in").send_keys(Keys.SPACE)
        self.until(lambda: picture() != whole)
        self.assertEqual((self.frame(), self.part("play").text), (0, "Play"))
        self.assertEqual(self.corrections(), [])

    def test_a_guess_is_called_one_and_undo_is_told(self):
        self.open_trial()
        self.seek(20)
        self.press("1")
        ankle = lambda: self.browser.find_element(By.CSS_SELECTOR, "[data-marker=ankle]").text
        self.press(Keys.ARROW_UP, holding=Keys.ALT)
        self.until(lambda: "placed by eye" in ankle())
        self.assertNotIn("detected", ankle())
        self.press("z", holding=Keys.CONTROL)
        self.until(lambda: self.text("said") == "Undone")

    def test_the_runs_own_warnings_stay_in_sight(self):
        self.copy_trial()
        summary = json.loads((self.trial / "summary.json").read_text())
        summary["warnings"] = ["the lamp flickers"]
        (self.trial / "summary.json").write_text(json.dumps(summary))
        self.open(self.trial)
        self.until(lambda: self.text("state") == "No corrections")
        self.assertIn("the lamp flickers", self.text("warnings"))

    NAMELESS = """
      const shown = [...document.querySelectorAll('button, input, select, textarea, progress, iframe, canvas, summary, a')]
        .filter(control => control.getClientRects().length > 0);
      return shown;"""

    def test_every_control_has_a_name_for_those_who_listen(self):
        for subject in ("trial", "optimum", self.compared(), "recording/video.mp4"):
            self.browser.get("about:blank")
            self.browser.get(self.start(subject).address)
            self.until(lambda: self.text("state") not in ("", "Loading", "Looking for markers", "Fitting the leg"))
            self.browser.execute_script("document.querySelectorAll('details').forEach(d => d.open = true)")
            controls = self.browser.execute_script(self.NAMELESS)
            self.assertGreater(len(controls), 5)
            for control in controls:
                name = control.accessible_name
                self.assertRegex(name, "[A-Za-z]{2}|l[1-6]", f"{subject}: {control.get_attribute('outerHTML')[:120]}")

    def test_two_windows_show_the_same_trial(self):
        review = self.open_trial()
        first = self.browser.current_window_handle
        self.browser.switch_to.new_window("tab")
        self.browser.get(review.address)
        self.until(lambda: self.frame() == 0)
        self.press("1", "h")
        self.until(lambda: self.is_corrected("ankle"))
        self.browser.switch_to.window(first)
        self.until(lambda: self.is_corrected("ankle"))
        self.part("undo").click()
        self.until(lambda: not self.is_corrected("ankle"))
        self.browser.switch_to.window(self.browser.window_handles[1])
        self.until(lambda: not self.is_corrected("ankle"))
        self.browser.close()
        # As long as a program takes that has lost its only window, which was closed after this one's.
        self.browser.switch_to.window(first)
        self.browser.switch_to.new_window("tab")
        other = self.start("optimum")
        self.browser.get(other.address)
        self.until(lambda: self.text("state") not in ("", "Loading"))
        self.browser.close()
        self.browser.switch_to.window(first)
        self.assertEqual(other.wait(), (0, ""))
        self.assertIsNone(review.process.poll(), "ended with the first of two windows")
        self.browser.get("about:blank")
        self.assertEqual(review.wait(), (0, ""))

    def test_names_exchanged_behind_a_hand_are_repaired_with_three_clicks(self):
        self.copy_trial()
        rows = read_table(self.trial / "tracks.csv")
        for row in rows[min(self.comes_back("knee"), self.comes_back("hip")):]:  # the hand has gone
            for column in ("x_px", "y_px", "sigma_px", "status"):
                row[f"knee_{column}"], row[f"hip_{column}"] = row[f"hip_{column}"], row[f"knee_{column}"]
        with open(self.trial / "tracks.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        review = self.open(self.trial)
        self.until(lambda: "No leg can be fitted" in self.text("warnings"))
        # Where the later of the two vanishes: before that, its name is right.
        later, other = sorted(("hip", "knee"), key=self.vanishes, reverse=True)
        self.browser.find_element(By.XPATH, f"//*[@id='problems']//button[contains(., '{later} not seen')]").click()
        self.until(lambda: self.frame() == self.vanishes(later))
        Select(self.part("swap-with")).select_by_value(other)
        self.part("swap").click()
        self.until(lambda: "No leg" not in self.text("warnings") and "saved" in self.text("state"))
        self.assertRegex(self.text("state"), r"^1 swap: \d+ corrections, saved$")
        repaired = review.ask("trial")["leg"]["knee"]
        tracked = [float(row["knee_deg"]) for row in read_table(self.trial / "kinematics.csv")]
        self.assertEqual(len(repaired), len(tracked))
        # As it was before the names were exchanged; the page's numbers have four digits behind the point.
        self.assertLess(max(abs(a - b) for a, b in zip(repaired, tracked)), 1e-4)

    def test_corrections_are_applied_in_the_page(self):
        review = self.open_trial()
        self.until(lambda: "No corrections" in self.text("state"))
        self.assertEqual(self.text("unapplied"), "")
        self.assertFalse(self.part("apply").is_enabled())
        self.seek(20)
        self.drag(self.place("knee", 20), (12, 0), holding=Keys.ALT)
        self.until(lambda: self.part("apply").is_enabled())
        self.assertIn("without these corrections", self.text("unapplied"))
        before = (self.trial / "tracks.csv").read_bytes()
        self.part("apply").click()
        self.until(lambda: "made with the corrections" in self.text("said"))
        self.until(lambda: self.text("unapplied") == "" and not self.part("apply").is_enabled())
        self.assertNotEqual((self.trial / "tracks.csv").read_bytes(), before)
        self.assertTrue(self.is_corrected("knee"))
        self.until(lambda: review.ask("state")["fitted"] == review.ask("state")["revision"])
        tracked = [float(row["knee_deg"]) for row in read_table(self.trial / "kinematics.csv")]
        self.assertLess(max(abs(a - b) for a, b in zip(review.ask("trial")["leg"]["knee"], tracked)), 1e-4)
        # They can be taken back, and that applied in turn.
        self.part("undo").click()
        self.until(lambda: self.part("apply").is_enabled() and not self.is_corrected("knee"))
        self.part("apply").click()
        self.until(lambda: self.text("unapplied") == "" and not self.part("apply").is_enabled())
        self.until(lambda: (self.trial / "tracks.csv").read_bytes() == before)

    def select(self, marker):
        self.browser.find_element(By.CSS_SELECTOR, f"#markers [data-marker={marker}]").click()

    def test_curves_are_copied(self):
        review = self.open_trial()
        self.browser.execute_cdp_cmd("Browser.grantPermissions", {
            "permissions": ["clipboardReadWrite", "clipboardSanitizedWrite"], "origin": review.address.rsplit("/", 2)[0]})
        self.select("hip")
        self.assertIn("hip", self.text("places-title"))
        copy = self.part("places-title").find_element(By.XPATH, "..").find_elements(By.TAG_NAME, "button")[0]
        copy.click()
        self.until(lambda: self.text("said") == "Copied")
        copied = self.browser.execute_async_script("navigator.clipboard.readText().then(arguments[0], arguments[0])")
        rows, trial = list(csv.DictReader(copied.splitlines())), review.ask("trial")
        hip, = [marker for marker in trial["markers"] if marker["name"] == "hip"]
        self.assertEqual(list(rows[0]), ["frame", "time_s", "x", "y"])
        self.assertEqual([int(row["frame"]) for row in rows], trial["frame"])
        self.assertAlmostEqual(float(rows[60]["x"]) - float(rows[0]["x"]), hip["x"][60] - hip["x"][0], places=3)

    def test_a_marker_that_is_not_found_is_asked_for(self):
        shutil.copy(self.folder / "recording/video.mp4", self.folder / "asked.mp4")
        self.open("asked.mp4")
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#spots button"))
        self.part("names").send_keys(", exo_knee", Keys.TAB)
        below = self.part("naming-picture").location["y"]
        self.part("start-tracking").click()
        self.until(lambda: "exo_knee was not found by itself: click it (1–" in self.text("ask"), "not asked for")
        self.assertEqual(self.part("naming-picture").location["y"], below)
        self.browser.execute_script("document.querySelector('#spots [data-spot=\"1\"]').click()")
        self.until(lambda: "--seed=exo_knee=#1" in self.text("naming-command"))
        self.assertNotIn("not found", self.text("ask"))
        # A trial that is there is replaced once that was confirmed.
        shutil.copytree(self.folder / "trial", self.folder / "lake-out/asked", dirs_exist_ok=True)
        self.open("asked.mp4")
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#spots button"))
        self.part("start-tracking").click()
        self.until(lambda: "holds a trial already" in self.text("said"))
        self.assertEqual(self.text("start-tracking"), "Replace the trial")

    def test_a_video_is_named_by_clicks(self):
        name = "<b>&'\" sit.mp4"
        shutil.copy(self.folder / "recording/video.mp4", self.folder / name)
        spots = {"ankle": (705.5, 648.9), "knee": (725.8, 429.2), "hip": (500.7, 407.1), "waist": (507.0, 297.0)}
        self.open(name)
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#spots button"))
        self.assertEqual(self.text("name"), name)
        for spot in spots.values():
            x, y, _ = self.on_screen("naming-picture", *spot)
            ActionChains(self.browser).move_to_element_with_offset(self.part("naming-picture"), x, y).click().perform()
        chosen = [button.text for button in self.browser.find_elements(By.CSS_SELECTOR, "#choices [data-name]")]
        self.assertEqual(chosen, [f"{name}: #{spot}" for name, spot in SEEDS.items()])
        self.until(lambda: f"--seed=waist=#{SEEDS['waist']}" in self.text("naming-command"))
        self.part("options").find_element(By.TAG_NAME, "summary").click()
        self.browser.find_element(By.CSS_SELECTOR, "[data-point=vertical]").click()
        for place in ((300, 100), (304, 500)):
            x, y, _ = self.on_screen("naming-picture", *place)
            ActionChains(self.browser).move_to_element_with_offset(self.part("naming-picture"), x, y).click().perform()
        self.until(lambda: "--vertical=30" in self.text("naming-command"))
        self.browser.execute_script(
            "const bar = arguments[0]; window.seen = [];"
            "new MutationObserver(() => window.seen.push(bar.value)).observe(bar, {attributes: true})",
            self.part("progress"))
        self.part("start-tracking").click()
        self.until(lambda: self.part("trial").is_displayed() and self.frame() == 0)
        progress = self.browser.execute_script("return window.seen")
        # How far it is stands there where it takes over two seconds, which it need not here.
        self.assertTrue(progress, "the bar was never moved")
        self.assertTrue(all(0 <= value <= 1 for value in progress), progress)
        self.until(lambda: "No corrections" in self.text("state"))
        self.assertEqual(self.status("waist"), "detected")
        self.assertEqual(self.browser.find_elements(By.CSS_SELECTOR, "h1 b"), [], "a name became part of the page")

    def click_picture(self, *place):
        # Offsets are from the middle of what is to be seen of an element.
        self.browser.execute_script("scrollTo(0, 0)")
        x, y, _ = self.on_screen("naming-picture", *place)
        ActionChains(self.browser).move_to_element_with_offset(self.part("naming-picture"), x, y).click().perform()

    def point(self, option, *places):
        self.browser.find_element(By.CSS_SELECTOR, f"[data-point={option}]").click()
        for place in places:
            self.click_picture(*place)

    def test_named_markers_are_locked(self):
        self.trial.mkdir()
        shutil.copy(self.folder / "recording/video.mp4", self.trial)
        shutil.copy(self.folder / "recording/camera.yaml", self.trial)
        self.open(self.trial / "video.mp4")
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#spots button"))
        self.assertGreater(int(self.part("naming-scrub").get_attribute("max")), 100)
        names = lambda: [button.text for button in self.browser.find_elements(By.CSS_SELECTOR, "#choices [data-name]")]
        spot = lambda number: self.browser.execute_script(f"document.querySelector('#spots [data-spot=\"{number}\"]').click()")
        for number in SEEDS.values():
            spot(number)
        named = [f"{name}: #{number}" for name, number in SEEDS.items()]
        self.assertEqual(names(), named)
        spot(2)  # any further one
        self.assertEqual(names(), named)
        self.assertIn("choose a name", self.text("said"))
        self.part("camera-beside").click()
        self.until(lambda: "--camera=" in self.text("naming-command"))
        self.answer_late("command")
        self.browser.find_element(By.XPATH, "//*[@id='choices']//button[.='Add exo_knee']").click()
        spot(SEEDS["waist"])
        self.until(lambda: "exo_knee" in self.text("naming-command"))
        self.assertIn(f"#{SEEDS['waist']} is waist", self.text("said"))
        spot(2)
        self.assertEqual(names(), named + ["exo_knee: #2"])
        self.press("z", holding=Keys.CONTROL)
        self.until(lambda: names() == named + ["exo_knee"])
        self.until(lambda: self.text("said") == "Undone")
        self.part("options").find_element(By.TAG_NAME, "summary").click()
        self.point("scale", (200, 100), (600, 100))
        self.browser.switch_to.alert.dismiss()
        self.until(lambda: self.text("said") == "")
        self.assertNotIn("error", self.part("said").get_attribute("class"))

    def test_paths_of_what_moves_are_drawn(self):
        """As in candidates.png: in the spot's own colour, yellow until it is named; what does not move has none."""
        review = self.open("recording/video.mp4")
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#spots button"))
        found = review.ask("naming", {})["spots"]
        waist, = [spot for spot in found if spot["id"] == SEEDS["waist"]]
        self.assertTrue(waist["moves"])
        away = max(waist["path"], key=lambda at: abs(at[0] - waist["x"]) + abs(at[1] - waist["y"]))
        self.until(lambda: self.yellow_at(away))
        self.browser.execute_script(f"document.querySelector('#spots [data-spot=\"{SEEDS['waist']}\"]').click()")
        self.until(lambda: not self.yellow_at(away))

    def yellow_at(self, place):
        """Pixels of #F0E442 within 3 px of a place of the naming picture."""
        x, y, _ = self.on_screen("naming-picture", *place)
        return self.browser.execute_script(
            "const [canvas, x, y] = arguments, scale = canvas.width / canvas.clientWidth;"
            "const at = [canvas.width / 2 + x * scale - 3, canvas.height / 2 + y * scale - 3].map(Math.round);"
            "const {data} = canvas.getContext('2d').getImageData(...at, 7, 7);"
            "let count = 0;"
            "for (let i = 0; i < data.length; i += 4)"
            "  count += data[i] > 170 && data[i + 1] > 160 && data[i + 2] < data[i] - 60;"
            "return count;", self.part("naming-picture"), x, y)

    def test_scale_part_and_colour_are_pointed_at(self):
        self.open("recording/video.mp4")
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#spots button"))
        self.part("options").find_element(By.TAG_NAME, "summary").click()
        self.point("scale", (200, 100), (600, 100))
        self.browser.switch_to.alert.send_keys("400")
        self.browser.switch_to.alert.accept()
        self.until(lambda: ",400" in self.text("naming-command"))
        x1, y1, x2, y2, length = self.said_numbers("scale")
        # A click is at a whole pixel of the screen.
        for said, asked in ((x1, 200), (y1, 100), (x2, 600), (y2, 100)):
            self.assertAlmostEqual(said, asked, delta=2)
        self.point("crop", (1000, 690), (300, 200))
        self.until(lambda: "--crop=" in self.text("naming-command"))
        for said, asked in zip(self.said_numbers("crop"), (300, 200, 700, 490)):
            self.assertAlmostEqual(said, asked, delta=3)
        self.until(lambda: "detections" in self.text("state"))
        # A reflective marker is no coloured one, which is said.
        self.point("color", self.place("ankle", 0))
        colour = self.browser.find_element(By.CSS_SELECTOR, "input[data-option=color]").get_attribute("value")
        self.assertRegex(colour, "^#([c-f][0-9a-f]){3}$")
        self.until(lambda: "error" in self.part("said").get_attribute("class"))
        self.browser.get_log("browser")  # that it was refused is on the console too

    def test_known_points_of_the_plane_are_pointed_at(self):
        self.open("recording/video.mp4")
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#spots button"))
        self.part("options").find_element(By.TAG_NAME, "summary").click()
        for place, mm in zip(((200, 600), (600, 600), (600, 300), (200, 300)), ("0,0", "800, 0", "800,600", "0,600")):
            self.point("plane-points", place)
            self.browser.switch_to.alert.send_keys(mm)
            self.browser.switch_to.alert.accept()
        self.until(lambda: "--plane-points=" in self.text("naming-command"))
        self.assertRegex(self.text("naming-command"), r"[\d.]+,[\d.]+=800,0; ?[\d.]+,[\d.]+=800,600")

    def test_patches_are_pointed_at(self):
        self.open("recording/video.mp4")
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#spots button"))
        self.part("options").find_element(By.TAG_NAME, "summary").click()
        Select(self.browser.find_element(By.CSS_SELECTOR, "[data-option=detector]")).select_by_visible_text("template")
        self.until(lambda: not self.browser.find_elements(By.CSS_SELECTOR, "#spots button"))
        for name in SEEDS:
            self.click_picture(*self.place(name, 0))
        self.until(lambda: re.search(r"--seed=waist=5\d\d\.\d,29\d\.\d@0 ", self.text("naming-command")))
        self.assertIn("--detector=template", self.text("naming-command"))
        chosen = [button.text for button in self.browser.find_elements(By.CSS_SELECTOR, "#choices [data-name]")]
        self.assertRegex(chosen[0], r"^ankle: \(70\d, 6[45]\d\) in frame 0$")

    def said_numbers(self, option):
        return [float(number) for number in self.text("naming-command").split(f"--{option}=")[1].split()[0].split(",")]

    def test_markers_are_named_without_a_mouse(self):
        review = self.open("recording/video.mp4")
        self.narrow_and_dark()
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#spots button"))
        self.until_narrow()
        self.browser.execute_script("document.querySelectorAll('#naming details').forEach(d => d.open = true)")
        for spot in SEEDS.values():
            self.browser.find_element(By.CSS_SELECTOR, f"#spots [data-spot='{spot}']").send_keys(Keys.ENTER)
            focused = self.browser.execute_script("return document.activeElement.dataset.spot")
            self.assertEqual(focused, str(spot), "Tab begins at the top again")
        self.until(lambda: f"--seed=waist=#{SEEDS['waist']}" in self.text("naming-command"))
        self.browser.execute_cdp_cmd("Browser.grantPermissions", {
            "permissions": ["clipboardReadWrite", "clipboardSanitizedWrite"], "origin": review.address.rsplit("/", 2)[0]})
        self.part("copy").send_keys(Keys.ENTER)
        self.until(lambda: self.text("said") == "Copied")
        copied = self.browser.execute_async_script("navigator.clipboard.readText().then(arguments[0], arguments[0])")
        self.assertEqual(copied, self.text("naming-command"))

    def test_a_tracking_that_fails_does_not_show_an_earlier_one(self):
        shutil.copy(self.folder / "recording/video.mp4", self.folder / "again.mp4")
        shutil.copytree(self.folder / "trial", self.folder / "lake-out/again")
        review = self.start("again.mp4")
        review.ask("track", {"markers": list(SEEDS), "seeds": SEEDS, "options": {"camera": "none.yaml"}})
        self.until(lambda: review.ask("state")["mode"] != "tracking", "still tracking")
        self.assertEqual(review.ask("state")["mode"], "naming")
        self.assertIn("none.yaml", review.ask("state")["job"]["failed"])

    # A design

    def open_design(self, subject="optimum", *options):
        self.browser.get("about:blank")
        review = self.start(subject, *options)
        self.browser.get(review.address)
        self.until(lambda: self.part("design").get_attribute("data-range"), "no design")
        return review

    def length(self, link):
        return float(self.browser.find_element(By.CSS_SELECTOR, f"[data-link='{link}'] [type=number]").get_attribute("value"))

    def set_length(self, link, length):
        field = self.browser.find_element(By.CSS_SELECTOR, f"[data-link='{link}'] [type=number]")
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(str(length), Keys.TAB)

    def failing(self):
        return [line.text for line in self.browser.find_elements(By.CSS_SELECTOR,
                                                                 "#checks [data-holds=false][data-asked=true]")]

    def drag_pin(self, pin, by):
        canvas = self.part("linkage")
        x, y = map(float, canvas.get_attribute(f"data-{pin}").split(","))
        chain = ActionChains(self.browser, duration=20)
        chain.move_to_element_with_offset(canvas, round(x - canvas.rect["width"] / 2), round(y - canvas.rect["height"] / 2))
        chain.click_and_hold().move_by_offset(*by).release().perform()

    def test_a_design_is_explored_and_saved(self):
        shutil.copytree(self.folder / "optimum", self.trial)
        saved = (self.trial / "design.yaml").read_bytes()
        self.open_design(self.trial)
        self.until(lambda: "meets all" in self.text("state"))
        self.set_length(6, 301)
        self.until(lambda: any("l6 ≤ 300 mm" in line and "fails by 1 mm" in line for line in self.failing()))
        self.until(lambda: "fails" in self.text("state"))
        self.press("z", holding=Keys.CONTROL)
        self.until(lambda: self.length(6) == 300 and not self.failing())
        before = [self.length(link) for link in range(1, 7)]
        self.press(*[Keys.ARROW_RIGHT] * 40)
        self.drag_pin("tip", (-4, 3))
        self.until(lambda: self.length(2) != before[1] and self.length(1) != before[0])
        self.assertEqual([self.length(link) for link in (3, 4, 5, 6)], before[2:], "the other pins do not stay")
        self.assertEqual(self.text("said"), "")
        dragged = self.length(2)
        self.part("design-save").click()
        self.until(lambda: "explored.yaml" in self.text("said"))
        self.assertIn(f"l2: {dragged:.1f}", (self.trial / "explored.yaml").read_text())
        self.part("design-save").click()
        self.until(lambda: "explored-2.yaml" in self.text("said"))
        self.assertEqual((self.trial / "design.yaml").read_bytes(), saved)
        self.browser.refresh()
        self.until_there("[data-link='2']")
        self.until(lambda: self.length(2) == dragged, "the links are lost when the page is loaded again")

    def test_a_link_slides_by_keys(self):
        self.open_design()
        before = self.length(2)
        slider = self.browser.find_element(By.CSS_SELECTOR, "[data-link='2'] [type=range]")
        slider.send_keys(Keys.ARROW_RIGHT * 5)
        self.until(lambda: abs(self.length(2) - before - 0.5) < 0.06)  # its steps are 0.1 mm, the first to the grid
        self.part("design-reset").send_keys(Keys.ENTER)
        self.until(lambda: self.length(2) == before)

    def test_a_slide_by_keys_is_undone_in_one_step(self):
        self.open_design()
        before = self.length(2)
        slider = self.browser.find_element(By.CSS_SELECTOR, "[data-link='2'] [type=range]")
        slider.send_keys(Keys.ARROW_RIGHT * 3)
        self.until(lambda: self.length(2) != before)
        slider.send_keys(Keys.CONTROL, "z")
        self.until(lambda: self.length(2) == before)
        self.assertEqual(self.text("said"), "Undone")
        # In a number's field it is the design that goes back, not the text alone.
        self.set_length(2, 70)
        self.until(lambda: abs(self.length(2) - 70) < 0.01 and ",70" in self.browser.current_url)
        field = self.browser.find_element(By.CSS_SELECTOR, "[data-link='2'] [type=number]")
        field.send_keys(Keys.CONTROL, "z")
        self.until(lambda: self.length(2) == before and f",{before:.1f}"[:4] in self.browser.current_url)

    def test_nobody_can_sit_down_in_it(self):
        self.trial.mkdir()
        (self.trial / "behind.yaml").write_text(PROBLEM + "mount: behind\n")
        self.open_design("optimum", "--problem", self.trial / "behind.yaml")
        self.set_length(6, 200)
        self.until(lambda: "not asked, and not met: seated angle" in self.text("state"))
        unasked = [line.text for line in self.browser.find_elements(By.CSS_SELECTOR, "#checks [data-asked=false]")]
        for need in ("Seated angle: ", "Clearance to the seat: ", "Actuator's clearance to the thigh: ",
                     "Actuator's clearance to the shank: "):
            line, = [line for line in unasked if line.startswith(need)]
            self.assertIn("not asked", line)
            self.assertNotIn("not asked at", line, "where its value is least, not where it is not asked")
            self.assertRegex(line, r": −?\d+(\.\d{1,2})?( mm|°)", "no finer than a workshop works")

    def test_builds_within_a_tolerance_follow(self):
        self.trial.mkdir()
        (self.trial / "robust.yaml").write_text(PROBLEM + "robust_mm: 0.2\n")
        review = self.open_design("optimum", "--problem", self.trial / "robust.yaml")
        links = review.ask("design")["links"]
        as_drawn, builds = (review.ask("explore", {"links": links, "builds": of}) for of in (False, True))
        self.assertEqual((as_drawn["of_builds"], builds["of_builds"]), (False, True))
        fails = lambda said: [check["name"] for check in said["checks"] if check["asked"] and not check["holds"]]
        self.assertEqual(fails(as_drawn), [])
        # At its limits as it is drawn, so a build that is off breaks them.
        self.assertIn("force", fails(builds))
        self.until(lambda: "also with every length off by up to 0.2 mm" in self.text("state"))
        self.assertEqual(len(self.failing()), len(fails(builds)))
        # What stands there until the builds are known may be gone before it is looked at.
        self.browser.execute_script("""
            const state = document.getElementById("state");
            window.states = [];
            new MutationObserver(() => states.push(state.innerText.replaceAll("\\u00a0", " "))).observe(state, {childList: true});
        """)
        self.set_length(1, 60)
        self.until(lambda: any("builds within ± 0.2 mm follow" in state for state in self.browser.execute_script("return states")))
        self.until(lambda: "also with every length off" in self.text("state"))

    def test_two_programs_save_under_their_own_names(self):
        self.trial.mkdir()
        shutil.copy(self.folder / "optimum/design.yaml", self.trial)
        both = [self.start(self.trial / "design.yaml") for _ in range(2)]
        links, saved = both[0].ask("design")["links"], []

        def save(review):
            for _ in range(20):
                saved.append(review.ask("save", {"links": links})["saved"])

        threads = [threading.Thread(target=save, args=[review]) for review in both]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(set(saved)), 40)
        self.assertEqual(len(list(self.trial.glob("explored*.yaml"))), 40)

    def test_a_studys_design_has_the_studys_limits(self):
        """Seat and plates are those of the study's other sections, files are named from the study file."""
        self.trial.mkdir()
        (self.trial / "mine.csv").write_text("name,closed_mm,stroke_mm\nmine,242,140\n")
        inline = "standing_deg: 5\nactuator: mine.csv\nclearances: {seat_mm: 1}\n"
        step = self.trial / "out/optimum"
        run(BIN / "lake-optimize", "--problem", "full.yaml", "--starts", 1, "--quiet", "-o", step, cwd=self.trial,
            files={self.trial / "full.yaml": inline + "body: {seat_edge_mm: 150}\nparts: {bar_width_mm: 40}\n"})
        summary = json.loads((step / "summary.json").read_text())
        summary["options"] = {"problem": {"standing_deg": 5, "actuator": "mine.csv", "clearances": {"seat_mm": 1}}}
        summary["given"] = []
        (step / "summary.json").write_text(json.dumps(summary))
        (self.trial / "study.yaml").write_text("name: x\n")
        (self.trial / "out/summary.json").write_text(
            json.dumps({"program": "lake-run", "options": {"study": "study.yaml"}}))
        review = self.start(step)
        told = review.ask("explore", {"links": review.ask("design")["links"]})["checks"]
        for requirement in summary["optimum"]["requirements"]:
            check, = [check for check in told if check["name"] == requirement["name"]]
            self.assertAlmostEqual(check["value"], requirement["value"], delta=1e-3, msg=requirement["name"])
        self.assertIn("seat clearance", [check["name"] for check in told])

    def test_what_a_design_was_given_is_handed_on(self):
        """An option that says the default's value stands above the problem file; what only the file says is not given."""
        self.trial.mkdir()
        run(BIN / "lake-optimize", "--problem", "thick.yaml", "--pin-diameter", 8, "--starts", 1, "--quiet", "-o", "optimum",
            cwd=self.trial, files={self.trial / "thick.yaml": PROBLEM + "parts: {pin_diameter_mm: 12, bar_width_mm: 40}\n"})
        summary = json.loads((self.trial / "optimum/summary.json").read_text())
        self.assertEqual([summary["options"][name] for name in ("pin-diameter", "bar-width")], ["8", "40"])
        self.assertEqual(summary["given"], ["problem", "pin-diameter", "starts"])
        review = self.start(self.trial / "optimum")
        command = review.ask("optimise-command", {"links": review.ask("design")["links"]})["command"]
        self.assertRegex(command, r"^lake optimize --problem \S*thick.yaml --pin-diameter 8 --start ")

    def test_a_design_is_optimised_from_here(self):
        review = self.open_design()
        best = [self.length(link) for link in range(1, 7)]
        self.set_length(1, 60)
        self.until(lambda: "139.50°" in self.text("state"))
        self.until(lambda: "--start 60," in self.text("optimise-command"))
        self.assertRegex(self.text("optimise-command"), r"^lake optimize --problem \S*problem.yaml --start 60,")
        self.hold_a_state_until_answered("optimise")
        self.part("optimise").click()
        self.until(lambda: "The optimum from these links" in self.text("said"))
        self.until(lambda: not self.failing())
        # The solver's own tolerance, and the two digits of the page.
        self.assertLess(max(abs(self.length(link) - best[link - 1]) for link in range(1, 7)), 0.02)
        self.assertTrue((self.folder / "lake-out/optimum-optimised/design.yaml").exists())
        self.press("z", holding=Keys.CONTROL)
        self.until(lambda: self.length(1) == 60)
        self.browser.get("about:blank")
        self.assertEqual(review.wait(), (0, ""))

    def test_a_design_without_limits_of_its_own_has_the_papers(self):
        self.trial.mkdir()
        design = (self.folder / "optimum/design.yaml").read_text()
        (self.trial / "design.yaml").write_text(design.replace("d_min_mm: 242", "d_min_mm: 245"))
        self.open_design(self.trial / "design.yaml")
        self.assertIn("the paper's problem", self.text("limits"))
        self.until(lambda: "give limits with --problem" in self.text("optimise-command"))
        self.assertFalse(self.part("optimise").is_displayed())

    def test_a_design_file_is_held_against_a_problem(self):
        self.trial.mkdir()
        shutil.copy(self.folder / "optimum/design.yaml", self.trial / "<i>.yaml")
        strict = PROBLEM.replace("2000", "1500")
        (self.trial / "strict.yaml").write_text(strict)
        self.open_design(self.trial / "<i>.yaml", "--problem", self.trial / "strict.yaml")
        line, = self.failing()
        self.assertRegex(line, "Force ≤ 1500 N: 2000 N\\s*fails by 500 N at 5.0°")
        self.assertEqual(self.text("name"), "<i>.yaml")
        self.set_length(2, 20)
        self.until(lambda: "These links cannot be assembled: " in self.text("state"))
        self.part("design-save").click()
        self.until(lambda: "cannot be saved" in self.text("said"))
        self.browser.get_log("browser")  # that it was refused is on the console too

    # A comparison and a study

    def compared(self):
        """The recording as both trials: its hip stands for the exoskeleton's joint."""
        if not (self.folder / "comparison").exists():
            run(BIN / "lake-compare", "trial", "trial", "--exo-knee", "knee", "--quiet", "-o", "comparison", cwd=self.folder)
        return "comparison"

    def test_two_trials_run_side_by_side(self):
        self.open(self.compared())
        self.until(lambda: self.part("comparison").is_displayed() and "0 % of the rise" in self.text("percent"))
        kinematics = read_table(self.folder / "trial/kinematics.csv")
        rise = [row for row in kinematics if row["repetition"] == "1" and row["percent"]]
        rows = read_table(self.folder / "comparison/misalignment.csv")
        for percent in (0, 40, 100):
            self.browser.execute_script(
                "const s = arguments[0]; s.value = arguments[1]; s.dispatchEvent(new Event('input'))",
                self.part("percent-scrub"), percent)
            nearest = min(rise, key=lambda row: abs(float(row["percent"]) - percent))["frame"]
            for trial in ("human", "exo"):
                self.until(lambda: self.part(f"{trial}-picture").get_attribute("data-frame") == nearest,
                           f"{trial} does not show frame {nearest}")
            self.assertIn(f"{float(rows[percent]['distance_mm']):.1f} mm apart", self.text("percent"))
        self.press(Keys.ARROW_LEFT)
        self.until(lambda: "99 % of the rise" in self.text("percent"))

    def test_another_rise_changes_the_numbers(self):
        run(BIN / "lake-synth", "--duration", 9, "--rate", 25, "--seed-number", 31, "--crf", 23, "--quiet", "-o", self.trial, cwd=self.folder)
        run(BIN / "lake-track", self.trial / "video.mp4", "--camera", self.trial / "camera.yaml", "--no-overlay", "--quiet",
            "-o", self.trial / "track", cwd=self.folder)
        run(BIN / "lake-compare", self.trial / "track", self.folder / "trial", "--exo-knee", "knee", "--quiet", "-o",
            self.trial / "comparison", cwd=self.folder)
        self.open(self.trial / "comparison")
        self.until(lambda: self.part("comparison").is_displayed() and "0 % of the rise" in self.text("percent"))
        rises = [option.text for option in Select(self.part("human-rise")).options]
        self.assertEqual(rises[:3], ["mean of all rises", "rise 1", "rise 2"])
        said = set()
        for rise in rises[:3]:
            Select(self.part("human-rise")).select_by_visible_text(rise)
            self.until(lambda: rise == "mean of all rises" or rise in self.text("state"))
            said.add((self.text("state"), self.text("percent")))
        self.assertEqual(len(said), 3)

    def test_a_study_is_shown_and_opens_its_trials_from_any_folder(self):
        """Its files are named from the folder in which the study was run, which is neither here nor above the results."""
        trial, results = self.folder / "trial", self.folder / "elsewhere/out"
        (self.trial / "problems").mkdir(parents=True)
        (self.trial / "problems/limits.yaml").write_text(PROBLEM)
        (self.trial / "study.yaml").write_text(
            f"name: Two <b>trials</b>\nhuman: {{trial: {trial}}}\nexo: {{trial: {trial}}}\ncompare: {{exo_knee: knee}}\n"
            "design: {problem: problems/limits.yaml, starts: 1}\n" + NO_ANIMATION)
        run(BIN / "lake-run", "study.yaml", "--quiet", "-o", results, cwd=self.trial)
        review = Review("/", results)
        self.addCleanup(review.close)
        self.browser.get(review.address)
        self.until(lambda: self.text("name") == "Two <b>trials</b>")
        self.assertIn("-o", self.text("study-command"))
        with self.assertRaises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(f"{review.address}results/..%2fstudy.yaml", timeout=WAIT_S)
        refused.exception.close()
        self.browser.switch_to.frame(self.part("report"))
        self.until_there("h1")
        self.assertEqual(self.browser.execute_script("return window.origin"), "null", "the report may ask the server")
        self.browser.switch_to.default_content()
        here = self.browser.current_window_handle
        for step, shown in (("human", "trial"), ("comparison", "comparison"), ("optimum", "design")):
            self.browser.find_element(By.CSS_SELECTOR, f"[data-step={step}]").click()
            self.until(lambda: len(self.browser.window_handles) == 2)
            self.browser.switch_to.window(next(one for one in self.browser.window_handles if one != here))
            self.until(lambda: self.browser.find_elements(By.ID, shown) and self.part(shown).is_displayed(), shown)
            self.browser.close()
            self.browser.switch_to.window(here)
        self.narrow_and_dark()
        self.until_narrow()
        self.assertEqual(review.end()[0], 130)
        self.until(lambda: "lake review has ended" in self.text("said"))
        self.forget_unanswered()
        design = Review("/", results / "optimum")
        self.addCleanup(design.close)
        told = design.ask("explore", {"links": design.ask("design")["links"]})
        self.assertIn("force", [check["name"] for check in told["checks"]])

    def test_a_trial_that_was_carried_away_opens_from_any_folder(self):
        """By its list, which tells of what video it is."""
        with tempfile.TemporaryDirectory(prefix="lake-test-") as other:
            shutil.copytree(self.folder / "trial", pathlib.Path(other) / "trial")
            review = Review("/", pathlib.Path(other) / "trial")
            self.addCleanup(review.close)
            with urllib.request.urlopen(review.address + "frame/0", timeout=WAIT_S) as picture:
                self.assertEqual(picture.read(2), b"\xff\xd8", "no JPEG")
            review.close()

    def until_there(self, selector):
        end = time.monotonic() + WAIT_S
        while not self.browser.find_elements(By.CSS_SELECTOR, selector):
            self.assertLess(time.monotonic(), end, selector)
            time.sleep(0.08)

    # A folder to begin in

    def test_a_folder_to_begin_in(self):
        begin = self.trial
        begin.mkdir()
        shutil.copy(self.folder / "recording/video.mp4", begin / "sitting.mp4")
        shutil.copy(self.folder / "recording/video.mp4", begin)
        shutil.copytree(self.folder / "trial", begin / "lake-out/video")
        shutil.copy(self.folder / "recording/camera.yaml", begin / "lake-out")
        self.open(begin)
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#found li"))
        line = lambda path: self.browser.find_element(By.CSS_SELECTOR, f"#found [data-path='{path}']")
        self.assertIn("1280 × 720", line("sitting.mp4").text)
        self.assertIn("not tracked", line("sitting.mp4").text)
        self.assertNotIn("not tracked", line("video.mp4").text)
        self.assertIn("ankle, knee, hip, waist", line("lake-out/video").text)
        # A trial has a page of its own.
        line("lake-out/video").find_element(By.TAG_NAME, "button").click()
        here = self.browser.current_window_handle
        self.until(lambda: len(self.browser.window_handles) == 2)
        self.browser.switch_to.window(next(one for one in self.browser.window_handles if one != here))
        self.until(lambda: self.browser.find_elements(By.ID, "frame") and self.frame() == 0, "no trial")
        self.browser.close()
        self.browser.switch_to.window(here)
        # What is missing is said; nothing is half made.
        self.part("make-camera").click()
        self.until(lambda: "the board (chessboard:9x6:25) is missing" in self.text("said"))
        self.assertFalse((begin / "camera.yaml").exists())
        self.assertEqual(Select(self.part("start-human")).first_selected_option.text, "lake-out/video")
        self.part("make-study").click()
        self.until(lambda: self.text("said") == "Done")
        self.assertIn("lake-out/video", (begin / "study.yaml").read_text())
        self.until(lambda: "✓ lake-out/study" in self.text("step-report"))
        self.assertTrue((begin / "lake-out/study/report.html").exists())
        self.part("make-study").click()
        self.until(lambda: "study.yaml is there already" in self.text("said"))
        self.narrow_and_dark()
        self.until_narrow()

    def test_fits_a_narrow_window_in_the_dark(self):
        self.open_trial()
        self.narrow_and_dark()
        self.until_narrow()
        self.assertEqual(self.browser.execute_script("return getComputedStyle(document.body).backgroundColor"),
                         "rgb(26, 27, 29)")
        for subject in self.other_subjects():
            self.browser.get(self.start(subject).address)
            self.until(lambda: self.text("state") not in ("", "Loading"))
            self.until_narrow(subject)

    def test_every_text_can_be_read_in_light_and_dark(self):
        """Contrast of at least 4.5 (WCAG 2.1), type of at least 12 px, nothing cut off."""
        for subject in ["trial"] + self.other_subjects():
            self.browser.get("about:blank")
            self.browser.get(self.start(subject).address)
            self.until(lambda: self.text("state") not in ("", "Loading", "Fitting the leg"))
            for theme in ("light", "dark"):
                self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia",
                                             {"features": [{"name": "prefers-color-scheme", "value": theme}]})
                with self.subTest(subject=subject, theme=theme):
                    self.assertEqual(self.browser.execute_script(HARD_TO_READ), [])
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})

    def test_a_number_and_its_unit_stay_on_one_line(self):
        for subject in ["trial"] + self.other_subjects():
            self.browser.get("about:blank")
            self.browser.get(self.start(subject).address)
            self.until(lambda: self.text("state") not in ("", "Loading", "Fitting the leg"))
            shown = self.browser.execute_script(
                "const walk = document.createTreeWalker(document.querySelector('main:not([hidden])'), NodeFilter.SHOW_TEXT);"
                "const texts = []; while (walk.nextNode()) if (!walk.currentNode.parentElement.closest('code'))"
                "  texts.push(walk.currentNode.data); return texts;")
            self.assertTrue([text for text in shown if "\u00a0" in text], subject)
            self.assertEqual([text for text in shown if re.search(r"\d (mm|px|s|N|%)(?!\w)|± |\d–\d", text)], [], subject)

    def other_subjects(self):
        return ["optimum", self.compared()]

    def narrow_and_dark(self):
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia",
                                     {"features": [{"name": "prefers-color-scheme", "value": "dark"}]})
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                     {"width": 400, "height": 850, "deviceScaleFactor": 1, "mobile": True})
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.clearDeviceMetricsOverride", {})
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.setEmulatedMedia", {"features": []})

    def until_narrow(self, subject="the page"):
        """A page is laid out anew some time after its window has changed."""
        self.until(lambda: self.browser.execute_script("return document.documentElement.scrollWidth") <= 400,
                   f"{subject} is wider than its window")

    def test_refuses_strangers(self):
        review = self.start(self.copy_trial())
        host = review.address.split("/")[2]
        for path, headers in (("trial", {"Host": "evil.example"}), ("trial", {"Origin": "http://evil.example"}),
                              ("../trial", {}), ("frame/../../../etc/passwd", {})):
            with self.assertRaises(urllib.error.HTTPError, msg=path) as refused:
                review.ask(path, **headers)
            self.assertIn(refused.exception.code, (400, 403, 404))
            refused.exception.close()
        address = review.address
        review.address = address[:-2] + ("0" if address[-2] != "0" else "1") + "/"
        with self.assertRaises(urllib.error.HTTPError) as refused:
            review.ask("trial")
        self.assertIn(refused.exception.code, (403, 404))
        refused.exception.close()
        review.address = address
        port = host.split(":")[1]
        second = subprocess.run([BIN / "lake-review", self.trial, "--port", port], cwd=self.folder, capture_output=True,
                                text=True, timeout=WAIT_S)
        self.assertEqual(second.returncode, 1)
        self.assertIn(f"{host}: the port is in use", second.stderr)
        self.assertEqual(len(second.stderr.splitlines()), 1)
        with socket.create_connection(("127.0.0.1", int(port))) as idle:  # says nothing, and must not hold up the end
            self.assertEqual(review.end(signal.SIGTERM)[0], 143)
            idle.close()


if __name__ == "__main__":
    unittest.main()
