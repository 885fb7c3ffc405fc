"""What a lab does in the browser alone, each task with its clicks and seconds: the built programs, the sample study's films,
headless Chromium. LAKE_BIN: where the programs are."""
import csv
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import time
import unittest

try:
    import numpy
    from PIL import Image
    from browser import DRIVER, PageParts, headless
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.ui import Select
except ImportError:
    DRIVER, PageParts = None, object

BIN = pathlib.Path(os.environ.get("LAKE_BIN", "build/test/bin")).resolve()
SAMPLE = pathlib.Path(__file__).resolve().parents[2] / "data/sts-study"
WAIT_S = 300
MOST_TO_NAME = 10  # clicks
SQUARE_MM = 60
# Where the film's fifth marker and the knee beside it are, px; both must be pointed at (data/sts-study/study.yaml).
AT = {"knee": (728, 431), "exo_knee": (740, 415)}


def numbers_of(key):
    found = re.search(rf"{key}.*?data: \[(.*?)\]", (SAMPLE / "camera.yaml").read_text(), re.S)
    return numpy.array([float(number) for number in found[1].replace("\n", " ").split(",")])


def rotation(vector):
    angle = numpy.linalg.norm(vector)
    x, y, z = vector / angle
    cross = numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return numpy.eye(3) + numpy.sin(angle) * cross + (1 - numpy.cos(angle)) * cross @ cross


def draw_board(turn, place, path):
    """A chessboard of 9x6 inner corners as the sample's camera sees it, without its distortion; mm."""
    per_square, finer = 20, 3
    board = numpy.full((9 * per_square, 12 * per_square), 235, numpy.uint8)
    for row in range(7):
        for column in range(row % 2, 10, 2):
            board[(row + 1) * per_square:(row + 2) * per_square, (column + 1) * per_square:(column + 2) * per_square] = 20
    mm = SQUARE_MM / per_square
    of_board = numpy.array([[mm, 0, -2 * SQUARE_MM], [0, mm, -2 * SQUARE_MM], [0, 0, 1]])
    seen = numbers_of("camera_matrix").reshape(3, 3) @ numpy.column_stack([turn[:, 0], turn[:, 1], place]) @ of_board
    back = numpy.linalg.inv(numpy.diag([finer, finer, 1]) @ seen)
    picture = Image.fromarray(board).transform((1280 * finer, 720 * finer), Image.PERSPECTIVE, (back / back[2, 2]).ravel()[:8], Image.BICUBIC,
                                               fillcolor=120)
    picture.resize((1280, 720), Image.BOX).save(path)


def draw_boards(folder):
    (folder / "board").mkdir()
    random = numpy.random.default_rng(1)
    for view in range(14):
        away = random.uniform(2400, 3800)
        place = numpy.array([random.uniform(-0.17, 0.17) * away - 240, random.uniform(-0.07, 0.07) * away - 150, away])
        draw_board(rotation(random.uniform(-0.6, 0.6, 3) * [1, 1, 0.5]), place, folder / f"board/{view:02}.png")
    plane = rotation(numbers_of("plane_rvec"))
    draw_board(plane @ numpy.diag([1, -1, -1]), plane @ [-240, 900, 0] + numbers_of("plane_tvec"), folder / "plane.png")


@unittest.skipIf(DRIVER is None, "no chromedriver, selenium, numpy or PIL for this Python")
class Tasks(PageParts, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="lake-test-")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        for name in ("human.mp4", "exo.mp4", "worn.yaml", "problem.yaml"):
            shutil.copy(SAMPLE / name, cls.folder)
        draw_boards(cls.folder)
        cls.profile = tempfile.TemporaryDirectory(prefix="lake-test-")  # the page lists what lies in the folder
        cls.addClassCleanup(cls.profile.cleanup)
        cls.browser = headless(1300, 1300, cls.profile.name)
        cls.addClassCleanup(cls.browser.quit)
        cls.program = subprocess.Popen([BIN / "lake-review", cls.folder], stdout=subprocess.PIPE, text=True)
        cls.addClassCleanup(cls.program.wait)
        cls.addClassCleanup(cls.program.terminate)
        cls.browser.get(cls.program.stdout.readline().strip())
        cls.start = cls.browser.current_window_handle

    def setUp(self):
        self.clicks, self.began = 0, time.monotonic()

    def tearDown(self):
        print(f"{self.id().rsplit('.', 1)[1]}: {self.clicks} clicks, {time.monotonic() - self.began:.0f} s")

    def until(self, condition, what):
        self.wait_until(condition, WAIT_S, what)

    def click(self, part):
        (self.part(part) if isinstance(part, str) else part).click()
        self.clicks += 1
        return True

    def choose(self, name, text):
        def chosen():
            Select(self.part(name)).select_by_visible_text(text)
            return True

        self.until(chosen, f"cannot choose {text}")
        self.clicks += 2

    def to_new_window(self):
        self.until(lambda: len(self.browser.window_handles) == 2, "no window")
        self.browser.switch_to.window(next(window for window in self.browser.window_handles if window != self.start))
        self.until(lambda: self.browser.find_elements(By.ID, "state"), "no page")

    def back(self):
        self.browser.close()
        self.browser.switch_to.window(self.start)
        self.click("look-again")

    def open_found(self, path):
        self.until(lambda: self.click(self.browser.find_element(By.CSS_SELECTOR, f"#found [data-path='{path}'] button")), path)
        self.to_new_window()

    def is_tracked(self):
        return self.part("trial").is_displayed() and self.part("frame").get_attribute("data-frame") == "0"

    def track(self, film, select, button, markers=""):
        """Names a film's markers; one that is not found by itself is asked for and clicked."""
        clicks, began = self.clicks, time.monotonic()
        self.choose(select, film)
        self.click(button)
        self.to_new_window()
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#spots button") and self.part("camera-beside").is_displayed(), "no film")
        self.click("camera-beside")
        if markers:
            self.part("names").send_keys(markers, Keys.TAB)
        self.click("start-tracking")
        while True:
            self.until(lambda: self.is_tracked() or "not found by itself" in self.text("ask"), "neither tracked nor asked")
            if self.is_tracked():
                self.back()
                print(f"markers of {film}: {self.clicks - clicks} clicks, {time.monotonic() - began:.0f} s")
                return self.assertLessEqual(self.clicks - clicks, MOST_TO_NAME)
            self.click_spot(AT[self.text("ask").split()[0]])
            self.click("start-tracking")
            time.sleep(1)

    def click_spot(self, place):
        def away(spot):
            x, y = re.search(r"\((\d+), (\d+)\)", spot.get_attribute("textContent")).groups()
            return abs(int(x) - place[0]) + abs(int(y) - place[1])

        spot = min(self.browser.find_elements(By.CSS_SELECTOR, "#spots button"), key=away)
        self.clicks += 1
        self.browser.execute_script("arguments[0].click()", spot)

    def test_1_from_a_board_and_two_films_to_the_report(self):
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#found li"), "nothing found")
        self.choose("start-views", "board")
        self.part("start-board").send_keys(f"chessboard:9x6:{SQUARE_MM}")
        self.choose("start-plane", "plane.png")
        self.click("make-camera")
        self.until(lambda: "✓ camera.yaml" in self.text("step-camera"), "no camera")
        self.track("human.mp4", "start-human-film", "track-human")
        self.track("exo.mp4", "start-exo-film", "track-exo", ", exo_knee")
        self.until(lambda: "✓" in self.text("step-human") and "✓" in self.text("step-exo"), "no trials")
        self.choose("start-worn", "worn.yaml")
        self.choose("start-problem", "problem.yaml")
        for name, number in (("start-rise", 12), ("start-speed", 20), ("start-percent", 2)):
            self.part(name).send_keys(number)
            self.clicks += 1
        self.click("make-study")
        self.until(lambda: self.text("said") == "Done", self.text("said"))
        self.click("open-report")
        self.to_new_window()
        self.until(lambda: self.part("report").is_displayed(), "no report")
        self.back()
        report = (self.folder / "lake-out/study/report.html").read_text()
        # The rendered joint is 37 mm from the knee; the board gives the plane, not the sample's camera file.
        self.assertRegex(report, r"joint is 3[67](\.\d)?\u00a0mm|joint is 3[67](\.\d)? mm")
        self.assertLessEqual(self.clicks, 30)

    def test_2_a_swap_over_200_frames_is_put_right_and_compared_again(self):
        trial = self.folder / "lake-out/exo"
        with open(trial / "tracks.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        for row in rows[300:500]:
            for column in ("x_px", "y_px", "sigma_px", "status"):
                row[f"knee_{column}"], row[f"exo_knee_{column}"] = row[f"exo_knee_{column}"], row[f"knee_{column}"]
        with open(trial / "tracks.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        self.open_found("lake-out/exo")
        self.until(lambda: self.is_tracked(), "no trial")
        self.click(self.browser.find_element(By.CSS_SELECTOR, "#markers [data-marker=knee]"))
        for frame in (300, 500):
            self.part("go-to").clear()
            self.part("go-to").send_keys(frame, Keys.TAB)
            self.until(lambda frame=frame: self.part("frame").get_attribute("data-frame") == str(frame), "frame")
            Select(self.part("swap-with")).select_by_value("exo_knee")
            self.click("swap")
            self.until(lambda frame=frame: f"from frame {frame} on" in self.text("said"), "not swapped")
        self.until(lambda: "2 swaps: 400 corrections" in self.text("state"), "not saved")
        self.click("apply")
        self.until(lambda: "made with the corrections" in self.text("said"), "not applied")
        self.back()
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#found [data-path='lake-out/study']"), "no study")
        self.open_found("lake-out/study")
        self.until(lambda: self.text("study-command"), "no command")
        program, *words = shlex.split(self.text("study-command"))
        subprocess.run([BIN / program, *words, "--quiet"], cwd=self.folder, check=True)
        self.assertRegex((self.folder / "lake-out/study/report.html").read_text(), r"joint is 3[67]")
        self.back()
        self.assertLessEqual(self.clicks, 12)

    def test_3_whether_new_links_are_worth_it(self):
        """From the folder's page: the report's first screen compares three ways and says which to take, and why."""
        self.open_found("lake-out/study")
        self.until(lambda: self.part("report").is_displayed(), "no report")
        self.browser.switch_to.frame(self.part("report"))
        result = self.browser.find_element(By.TAG_NAME, "section").text
        self.browser.switch_to.default_content()
        self.back()
        for said in ("New links help", "as worn", "same links, joint moved", "new links", "Limits that are violated"):
            self.assertIn(said, result)
        self.assertLessEqual(self.clicks, 2)


if __name__ == "__main__":
    unittest.main()
