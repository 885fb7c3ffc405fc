#!/usr/bin/python3
"""How long after its arrival lake-live has told a frame, how long until it is seen on the page, and what a frame costs.

Rendered films of 720p and 1080p at 30, 60 and 120 Hz, replayed at their own pace as a camera sends them: Motion JPEG, and
H.264 without B-frames. Printed are the frames that came and that were looked at; the latency's median, 95 % quantile and
largest; and the processor time of a frame (all threads of lake-live: received, recorded, decoded, tracked, rises measured;
lake-track's afterwards is not in it). A busy machine makes the latency worse, and the processor time hardly: "busy" is what
programs not of this measurement took of the processors meanwhile. The aim is 100 ms for 95 % up to 1080p60.

With --page a window of headless Chromium on this machine shows the session. A frame counts as seen in the first picture
that the browser has painted after it was drawn; the page shows as many frames as it can and leaves the others out. The
processor time is then also the server's, and the browser's own is printed beside it.

Usage: tests/benchmark/live_latency.py [--page] [--only TEXT] [FOLDER OF THE PROGRAMS]   (default: build/release/bin)
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time
import urllib.request

HERE = pathlib.Path(__file__).resolve().parent
TICK_S = 1 / os.sysconf("SC_CLK_TCK")
CODED = {"MJPEG": ("film.avi", "-c:v", "mjpeg", "-q:v", "3", "-pix_fmt", "yuvj420p"),
         "H.264": ("film.mp4", "-c:v", "libx264", "-preset", "veryfast", "-tune", "zerolatency", "-crf", "18")}
# How late each frame is that is drawn, once it has been painted.
WATCH = """
const picture = document.getElementById("live-picture");
window.late_ms = [];
new MutationObserver(() => {
  const arrived = Number(picture.dataset.arrived), painted = new MessageChannel();
  painted.port1.onmessage = () => late_ms.push(performance.timeOrigin + performance.now() - arrived);
  requestAnimationFrame(() => painted.port2.postMessage(""));
}).observe(picture, { attributeFilter: ["data-frame"] });
"""


def run(*words):
    return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True).stdout


def machine_s():
    with open("/proc/stat", encoding="ascii") as file:
        user, nice, system = (int(word) for word in file.readline().split()[1:4])
    return (user + nice + system) * TICK_S


def own_s(process):
    """Of all its threads and none of its children; also of one that has ended and was not waited for."""
    words = pathlib.Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) * TICK_S


def family_s(process):
    """Of it, and of its children and theirs that live."""
    children = pathlib.Path(f"/proc/{process}/task/{process}/children").read_text(encoding="ascii").split()
    return own_s(process) + sum(family_s(child) for child in children)


def phase(address):
    with urllib.request.urlopen(address + "state") as answer:
        return json.load(answer)["phase"]


def quantiles(values):
    values = sorted(values)
    return " ".join(f"{values[min(int(share * len(values)), len(values) - 1)]:6.1f}" for share in (0.5, 0.95, 1))


class Browser:
    def __init__(self, folder):
        from selenium import webdriver  # Debian's python3-selenium
        from selenium.webdriver.chrome.service import Service
        options = webdriver.ChromeOptions()
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--window-size=1400,1250",
                         f"--user-data-dir={folder / 'profile'}"):
            options.add_argument(argument)
        self.service = Service(shutil.which("chromedriver"))
        self.driver = webdriver.Chrome(options=options, service=self.service)

    def watch_all(self, address):
        """How late each frame was that was seen, ms."""
        self.driver.get(address)
        self.driver.execute_script(WATCH)
        while phase(address) in ("watching", "trial"):
            time.sleep(0.5)
        late_ms = self.driver.execute_script("return window.late_ms")
        self.driver.get("about:blank")
        return late_ms

    def processor_s(self):
        return family_s(self.service.process.pid)


def play(programs, folder, browser, title, film):
    frames = int(run("ffprobe", "-v", "error", "-count_packets", "-select_streams", "v", "-show_entries", "stream=nb_read_packets",
                     "-of", "csv=p=0", film).split()[0].strip(","))
    shutil.rmtree(folder / "out", ignore_errors=True)
    before_s, browser_s, children, began = machine_s(), browser.processor_s() if browser else 0, os.times(), time.monotonic()
    live = subprocess.Popen([programs / "lake-live", film, "--replay", "--camera", folder / "film/camera.yaml", "--no-overlay", "-o",
                             folder / "out"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    said = ""
    while not said.startswith("http://"):
        if not (said := live.stderr.readline()):
            raise SystemExit(f"{title}: lake-live did not begin")
    late_ms = browser.watch_all(said.strip()) if browser else []
    os.waitid(os.P_PID, live.pid, os.WEXITED | os.WNOWAIT)
    live_s = own_s(live.pid)
    if live.wait() != 0:
        raise SystemExit(f"{title}: {live.stderr.read()}")
    browser_s = browser.processor_s() - browser_s if browser else 0
    now = os.times()
    ours_s = now.children_user - children.children_user + now.children_system - children.children_system + browser_s
    others = (machine_s() - before_s - ours_s) / (time.monotonic() - began) / os.cpu_count()
    told = json.loads((folder / "out/live.json").read_text(encoding="utf-8"))
    ms = told["latency_ms"]
    print(f"{title:<19} {frames:>5} frames, {told['frames']:>5} looked at; told after {ms['median']:6.1f} {ms['of_95_percent']:6.1f} "
          f"{ms['largest']:6.1f} ms; {1000 * live_s / frames:5.1f} ms of processor; others {100 * max(others, 0):3.0f} % busy", flush=True)
    if browser:
        print(f"{'':<19} {len(late_ms):>5} seen on the page after {quantiles(late_ms)} ms; {1000 * browser_s / max(len(late_ms), 1):5.1f} ms of "
              "processor for each in the browser", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--page", action="store_true")
    parser.add_argument("--only", default="", help="part of the titles to be played, such as '1080p 60'")
    parser.add_argument("programs", nargs="?", type=pathlib.Path, default=HERE / "../../build/release/bin")
    asked = parser.parse_args()
    programs = asked.programs.resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        browser = Browser(folder) if asked.page else None
        try:
            for scene, size in (("clean", "720p"), ("hard", "1080p")):
                for rate in (30, 60, 120):
                    titles = [title for title in (f"{size} {rate} Hz {coding}" for coding in CODED) if asked.only in title]
                    if not titles:
                        continue
                    run(programs / "lake-synth", "--scene", scene, "--exo", "18,32", "--exoskeleton", "--duration", 8, "--rate", rate,
                        "--seed-number", 38, "--quiet", "-o", folder / "film")
                    for title in titles:
                        film, *words = CODED[title.split()[-1]]
                        run("ffmpeg", "-nostdin", "-v", "error", "-y", "-i", folder / "film/video.mp4", *words, folder / film)
                        play(programs, folder, browser, title, folder / film)
                    shutil.rmtree(folder / "film")
        finally:
            if browser:
                browser.driver.quit()


if __name__ == "__main__":
    main()
