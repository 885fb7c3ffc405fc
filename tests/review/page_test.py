"""lake review as a person uses it: the built program, a rendered recording, headless Chromium.

One browser and one recording serve all tests. LAKE_BIN: where the programs are."""
import csv
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import unittest
import urllib.error
import urllib.request

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.common.exceptions import StaleElementReferenceException
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.ui import Select
except ImportError:
    webdriver = None

BIN = pathlib.Path(os.environ.get("LAKE_BIN", "build/test/bin")).resolve()
DRIVER = shutil.which("chromedriver")
WAIT_S = 60  # a loaded machine; what is waited for takes a second
SIZE = (1280, 720)  # of the recording, px
# lake track needs to be told: a hand hides knee and hip at once, and before and after it the leg bends too little.
SEEDS = {"ankle": 6, "knee": 5, "hip": 4, "waist": 1}


# With the limits of calibration/problems/buildable.yaml.
PROBLEM = """standing_deg: 5
margins: {grashof_mm: 2, singularity_mm: 2}
load: {knee_torque_nm: 40, max_force_n: 2000}
min_transmission_deg: 10
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
            text=True)
        self.address = self.process.stdout.readline().strip()

    def ask(self, path, message=None, **headers):
        data = None if message is None else json.dumps(message).encode()
        request = urllib.request.Request(self.address + path, data, {"Content-Type": "application/json", **headers})
        with urllib.request.urlopen(request, timeout=WAIT_S) as response:
            return json.load(response)

    def end(self, sign=signal.SIGINT):
        self.process.send_signal(sign)
        return self.wait()

    def close(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.process.stderr.close()

    def wait(self):
        err = self.process.communicate(timeout=WAIT_S)[1]
        return self.process.returncode, err


@unittest.skipIf(webdriver is None or DRIVER is None, "no chromedriver and selenium for this Python "
                 "(Debian packages chromium-driver and python3-selenium)")
class ReviewPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="lake-test-")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        run(BIN / "lake-synth", "--duration", 4, "--rate", 30, "--seed-number", 31, "--hide", "knee=1.6,0.3",
            "--hide", "hip=1.6,0.3", "--quiet", "-o", cls.folder / "recording")
        run(BIN / "lake-track", "recording/video.mp4", "--camera", "recording/camera.yaml", "--no-overlay", "--quiet",
            "-o", "trial", *[f"--seed={name}=#{spot}" for name, spot in SEEDS.items()], cwd=cls.folder)
        run(BIN / "lake-optimize", "--problem", "problem.yaml", "--starts", 1, "--quiet", "-o", "optimum", cwd=cls.folder,
            files={cls.folder / "problem.yaml": PROBLEM})
        options = webdriver.ChromeOptions()
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                         "--window-size=1300,1100", f"--user-data-dir={cls.folder / 'profile'}"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        cls.browser = webdriver.Chrome(options=options, service=Service(DRIVER))
        cls.addClassCleanup(cls.browser.quit)

    def setUp(self):
        self.trial = self.folder / self.id().rsplit(".", 1)[1]

    def tearDown(self):
        log = [line for line in self.browser.get_log("browser") if line["level"] == "SEVERE"]
        self.browser.get("about:blank")
        self.assertEqual(log, [])

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

    def part(self, name):
        return self.browser.find_element(By.ID, name)

    def text(self, name):
        return self.part(name).text

    def until(self, condition, what=None):
        def holds():
            try:
                return condition()
            except StaleElementReferenceException:  # the page replaced an element between two questions
                return False

        end = time.monotonic() + WAIT_S
        while not holds():
            self.assertLess(time.monotonic(), end, what or f"{self.text('state')} {self.text('said')}")
            time.sleep(0.03)

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
        while "knee not seen, frames 47 to 58" not in self.text("said"):
            self.press("]")
            self.assertNotIn("no further problem", self.text("said"))
        self.until(lambda: self.frame() == 47)
        self.assertEqual((self.status("knee"), self.status("ankle")), ("filled", "detected"))
        self.seek(0)
        self.press("[")
        self.assertIn("no further problem", self.text("said"))
        self.seek(47)
        self.press(" ")
        self.until(lambda: self.frame() > 49)
        self.press(" ")
        elsewhere = self.browser.execute_script(
            "return performance.getEntriesByType('resource').map(e => e.name).filter(n => !n.startsWith(location.href))")
        self.assertEqual(elsewhere, [], "fetched from elsewhere")

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
        review.close()  # killed: nothing of what was saved is lost
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
        self.browser.get_log("browser")  # that nobody answers any more is on the console too

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
        self.browser.switch_to.window(first)
        time.sleep(3.5)
        self.assertIsNone(review.process.poll(), "ended with the first of two windows")
        self.browser.get("about:blank")
        self.assertEqual(review.wait(), (0, ""))

    def test_names_exchanged_behind_a_hand_are_repaired_with_three_clicks(self):
        self.copy_trial()
        rows = read_table(self.trial / "tracks.csv")
        for row in rows[59:]:  # the hand has gone
            for column in ("x_px", "y_px", "sigma_px", "status"):
                row[f"knee_{column}"], row[f"hip_{column}"] = row[f"hip_{column}"], row[f"knee_{column}"]
        with open(self.trial / "tracks.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        review = self.open(self.trial)
        self.until(lambda: "No leg can be fitted" in self.text("warnings"))
        # Where the later of the two vanishes: before that, its name is right.
        self.browser.find_element(By.XPATH, "//*[@id='problems']//button[contains(., 'hip not seen')]").click()
        self.until(lambda: self.frame() == 48)
        Select(self.part("swap-with")).select_by_value("knee")
        self.part("swap").click()
        self.until(lambda: self.text("warnings") == "" and "saved" in self.text("state"))
        repaired = review.ask("trial")["leg"]["knee"]
        tracked = [float(row["knee_deg"]) for row in read_table(self.trial / "kinematics.csv")]
        self.assertEqual(len(repaired), len(tracked))
        # As it was before the names were exchanged; the page's numbers have four digits behind the point.
        self.assertLess(max(abs(a - b) for a, b in zip(repaired, tracked)), 1e-4)

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
        chosen = [button.text for button in self.browser.find_elements(By.CSS_SELECTOR, "#choices button")]
        self.assertEqual(chosen, [f"{name}: #{spot}" for name, spot in SEEDS.items()])
        self.until(lambda: "--seed=waist=#1" in self.text("naming-command"))
        self.part("options").find_element(By.TAG_NAME, "summary").click()
        self.browser.find_element(By.CSS_SELECTOR, "[data-point=vertical]").click()
        for place in ((300, 100), (304, 500)):
            x, y, _ = self.on_screen("naming-picture", *place)
            ActionChains(self.browser).move_to_element_with_offset(self.part("naming-picture"), x, y).click().perform()
        self.until(lambda: "--vertical=30" in self.text("naming-command"))
        self.part("start-tracking").click()
        self.until(lambda: self.part("trial").is_displayed() and self.frame() == 0)
        self.until(lambda: "No corrections" in self.text("state"))
        self.assertEqual(self.status("waist"), "detected")
        self.assertEqual(self.browser.find_elements(By.CSS_SELECTOR, "h1 b"), [], "a name became part of the page")

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
        return [line.text for line in self.browser.find_elements(By.CSS_SELECTOR, "#checks [data-holds=false]")]

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
        for _ in range(40):
            self.press(Keys.ARROW_RIGHT)
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

    def test_a_design_is_optimised_from_here(self):
        review = self.open_design()
        best = [self.length(link) for link in range(1, 7)]
        self.set_length(1, 60)
        self.until(lambda: "139.50°" in self.text("state"))
        self.until(lambda: "--start 60," in self.text("optimise-command"))
        self.assertRegex(self.text("optimise-command"), r"^lake optimize --problem \S*problem.yaml --start 60,")
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
        self.until(lambda: "violate the triangle inequality" in self.text("state"))
        self.part("design-save").click()
        self.until(lambda: "cannot be saved" in self.text("said"))
        self.browser.get_log("browser")  # that it was refused is on the console too

    # A comparison and a study

    def compared(self):
        """The recording as both trials: its hip stands for the exoskeleton's joint."""
        if not (self.folder / "comparison").exists():
            run(BIN / "lake-compare", "trial", "trial", "--exo-knee", "hip", "--quiet", "-o", "comparison", cwd=self.folder)
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

    def test_a_study_is_shown_and_a_step_done_again(self):
        self.trial.mkdir()
        trial = self.folder / "trial"
        study = self.trial / "study.yaml"
        study.write_text(f"name: Two <b>trials</b>\nhuman: {{trial: {trial}}}\nexo: {{trial: {trial}}}\n"
                         "compare: {exo_knee: hip}\n")
        run(BIN / "lake-run", study, "--quiet", "-o", self.trial / "out", cwd=self.folder)
        review = self.open(self.trial / "out")
        self.until(lambda: "steps are up to date" in self.text("state"))
        self.assertEqual(self.text("name"), "Two <b>trials</b>")
        self.browser.switch_to.frame(self.part("report"))
        self.until_there("h1")
        self.assertEqual(self.browser.execute_script("return window.origin"), "null", "the report may ask the server")
        self.browser.switch_to.default_content()
        study.write_text(study.read_text().replace("exo_knee: hip", "exo_knee: waist"))
        self.browser.refresh()
        self.until_there("[data-step=comparison]")
        step = lambda: self.browser.find_element(By.CSS_SELECTOR, "[data-step=comparison]")
        self.until(lambda: "to be done" in step().text)
        step().find_element(By.TAG_NAME, "button").click()
        self.until(lambda: "comparison: done" in self.text("said"))
        self.until(lambda: "up to date" in step().text)
        summary = json.loads((self.trial / "out/comparison/summary.json").read_text())
        self.assertEqual(summary["markers"]["exo"], "waist")
        self.assertEqual(review.end()[0], 130)
        self.until(lambda: "lake review has ended" in self.text("said"))
        self.browser.get_log("browser")

    def until_there(self, selector):
        end = time.monotonic() + WAIT_S
        while not self.browser.find_elements(By.CSS_SELECTOR, selector):
            self.assertLess(time.monotonic(), end, selector)
            time.sleep(0.03)

    def test_fits_a_narrow_window_in_the_dark(self):
        self.open_trial()
        self.narrow_and_dark()
        self.assertLessEqual(self.browser.execute_script("return document.documentElement.scrollWidth"), 400)
        self.assertEqual(self.browser.execute_script("return getComputedStyle(document.body).backgroundColor"),
                         "rgb(26, 27, 29)")
        for subject in self.other_subjects():
            self.browser.get(self.start(subject).address)
            self.until(lambda: self.text("state") not in ("", "Loading"))
            self.assertLessEqual(self.browser.execute_script("return document.documentElement.scrollWidth"), 400, subject)

    def other_subjects(self):
        return ["optimum", self.compared()]

    def narrow_and_dark(self):
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia",
                                     {"features": [{"name": "prefers-color-scheme", "value": "dark"}]})
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                     {"width": 400, "height": 850, "deviceScaleFactor": 1, "mobile": True})
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.clearDeviceMetricsOverride", {})
        self.addCleanup(self.browser.execute_cdp_cmd, "Emulation.setEmulatedMedia", {"features": []})

    def test_refuses_strangers(self):
        review = self.start(self.copy_trial())
        host = review.address.split("/")[2]
        for path, headers in (("trial", {"Host": "evil.example"}), ("trial", {"Origin": "http://evil.example"}),
                              ("../trial", {}), ("frame/../../../etc/passwd", {})):
            with self.assertRaises(urllib.error.HTTPError, msg=path) as refused:
                review.ask(path, **headers)
            self.assertIn(refused.exception.code, (400, 403, 404))
            refused.exception.close()
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
