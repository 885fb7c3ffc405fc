"""The pictures of data/pages: the report and `lake review` of the sample study, `lake live` of a rendered session, by a headless browser.

    LAKE_BIN=build/test/bin /usr/bin/python3 tests/python/page_pictures.py [NAME...]

draws all, or those that are named, where they are kept. LAKE_STUDY: the sample study's results, where they are there already."""
import base64
import contextlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("LAKE_BIN", "build/test/bin")).resolve()
WAIT_S = 600  # a loaded machine; what is waited for takes some seconds
OF_SCREEN = 0.6  # of a wide page, whose letters can be read at that

# The page's name, its window's size in CSS px, and the scale of its picture.
PICTURES = {
    "first-screen.png": ("report", 1400, 900, OF_SCREEN),
    "first-screen-dark.png": ("report in the dark", 1400, 900, OF_SCREEN),
    "first-screen-phone.png": ("report", 400, 850, 1),
    "trial.png": ("trial", 1400, 900, OF_SCREEN),
    "explorer.png": ("explorer", 1400, 900, OF_SCREEN),
    "live-phone.png": ("live, before the first rise", 400, 900, 1),
    "live.png": ("live, after two rises", 1400, 1100, OF_SCREEN),
    "live-800.png": ("live, after two rises", 800, 1100, OF_SCREEN),
}


def until(is_so):
    end = time.monotonic() + WAIT_S
    while not (found := is_so()):
        if time.monotonic() > end:
            raise RuntimeError("waited in vain")
        time.sleep(0.05)
    return found


class Pages:
    """A browser, and which of the pictures it is to take."""

    def __init__(self, browser, wanted):
        self.browser, self.wanted = browser, wanted

    def are_wanted_of(self, *pages):
        return any(PICTURES[name][0] in pages for name in self.wanted)

    def show(self, address, is_ready=lambda: True):
        self.browser.get(address)
        until(is_ready)

    def text(self, part):
        return self.browser.find_element("id", part).text

    def take(self, page):
        for name in self.wanted:
            of, width, height, scale = PICTURES[name]
            if of == page:
                self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                             {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
                # Drawn at this size: two frames after the page has heard of it.
                self.browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
                shot = self.browser.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})
                # Made smaller from what a screen shows: at a small scale the browser leaves out thin lines.
                subprocess.run(["ffmpeg", "-v", "error", "-y", "-f", "png_pipe", "-i", "-", "-vf", f"scale=iw*{scale}:-1:flags=area",
                                ROOT / "data/pages" / name], input=base64.b64decode(shot["data"]), check=True)
                print(name, flush=True)


def take_report(pages, study):
    for page, theme in (("report", "light"), ("report in the dark", "dark")):
        pages.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": theme}]})
        pages.show((study / "report.html").as_uri())
        pages.take(page)
    pages.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def take_review(pages, study, page, step):
    sys.path.insert(0, str(ROOT / "tests/review"))
    import page_test
    review = page_test.Review(ROOT, study / step)
    with contextlib.closing(review):
        pages.show(review.address, lambda: pages.text("state") not in ("", "Loading", "Fitting the leg"))
        pages.take(page)
        pages.browser.get("about:blank")


def take_live(pages, folder):
    """Two rises with a joint that is where it should not be."""
    sys.path.insert(0, str(ROOT / "tests/live"))
    import live_test
    from live_test import MARKER_AT, NAMES, WORN
    live_test.synth(folder / "worn", [a + b for a, b in zip(WORN, MARKER_AT)])
    film = folder / "film.ts"
    live_test.ffmpeg("-i", folder / "worn/video.mp4", "-c", "copy", film)
    truth = live_test.read_table(folder / "worn/truth.csv")[0]
    camera = live_test.Camera(film)
    camera.send(camera.at(0.8))  # the person sits still
    seeds = [f"--seed={name}={truth[name + '_x_px']},{truth[name + '_y_px']}" for name in NAMES]
    live = live_test.Live(folder, "-", "--camera", folder / "worn/camera.yaml", "--joint-at", ",".join(map(str, MARKER_AT)),
                          "--tolerance", 6, "--patience", WAIT_S, "--no-overlay", "-o", "session", *seeds, stdin=camera.output)
    camera.is_read_by_another()
    with contextlib.closing(live):
        def is_shown():
            return pages.browser.find_element("id", "live-picture").get_attribute("data-frame")
        pages.show(live.address, lambda: is_shown() and pages.text("live-checks"))
        pages.take("live, before the first rise")
        if pages.are_wanted_of("live, after two rises"):
            pages.browser.find_element("id", "live-trial").click()
            rate_hz, frames = 30, live_test.frames_of(film)
            decoding = 15  # pictures that a decoder keeps until more come
            for second in range(1, frames // rate_hz):  # no faster than this machine keeps up, as nothing is late then
                camera.send(camera.at(second))
                until(lambda: int(is_shown()) >= second * rate_hz - decoding)
            camera.send()
            until(lambda: int(is_shown()) >= frames - decoding and pages.text("live-rise-count") == "2 rises")
            pages.take("live, after two rises")
        pages.browser.get("about:blank")
    camera.end()


def main(wanted):
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    with tempfile.TemporaryDirectory(prefix="lake-pages-") as name:
        folder = pathlib.Path(name)
        options = webdriver.ChromeOptions()
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
                         f"--user-data-dir={folder / 'profile'}"):
            options.add_argument(argument)
        browser = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
        pages = Pages(browser, wanted)
        with contextlib.ExitStack() as ended:
            ended.callback(browser.quit)
            if pages.are_wanted_of("report", "report in the dark", "trial", "explorer"):
                study = pathlib.Path(os.environ.get("LAKE_STUDY", folder / "study"))
                if not study.exists():
                    subprocess.run([BIN / "lake-run", ROOT / "data/sts-study/study.yaml", "--quiet", "-o", study], check=True)
                if pages.are_wanted_of("report", "report in the dark"):
                    take_report(pages, study)
                for page, step in (("trial", "exo"), ("explorer", "redesign")):
                    if pages.are_wanted_of(page):
                        take_review(pages, study, page, step)
            if pages.are_wanted_of("live, before the first rise", "live, after two rises"):
                take_live(pages, folder)


if __name__ == "__main__":
    main(sys.argv[1:] or list(PICTURES))
