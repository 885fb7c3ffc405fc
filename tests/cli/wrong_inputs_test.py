"""Wrong inputs, each with what its message must name: one line, and the way out in it."""
import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

BIN = pathlib.Path(os.environ.get("LAKE_BIN", "build/test/bin")).resolve()
DATA = pathlib.Path(__file__).resolve().parents[2] / "data/sts-study"
WAIT_S = 60
LEAST = 300  # rows

# What is right in each program's command line, to which an option is added: "…" in the rows.
RIGHT = {
    "anonymise": "film.mp4 --trial empty",
    "axis": "trial.csv --segment shank=ankle,knee --segment thigh=hip,waist",
    "calibrate": "film.mp4 --board chessboard:9x6:25",
    "check": "film.mp4",
    "cohort": "empty participant",
    "compare": "trial.csv trial.csv",
    "convert": "trial.csv o.trc",
    "export": "design.yaml mjcf",
    "gait": "trial.csv",
    "info": "trial.csv",
    "live": "film.mp4 --replay",
    "loads": "trial.csv --mass 70",
    "optimize": "",
    "redesign": "",
    "review": "empty",
    "run": "study.yaml",
    "simulate": "design.yaml",
    "stroke": "design.yaml",
    "symmetry": "trial.csv trial.csv",
    "sync": "trial.csv trial.csv",
    "synth": "",
    "track": "film.mp4",
}

# Options whose value is a number, given a word.
NUMBERS = {
    "anonymise": "threads crf capture-rate",
    "axis": "threads rate window least-turn soft-tissue",
    "calibrate": "threads max-views",
    "check": "threads",
    "cohort": "threads cores jobs",
    "compare": """threads height mass belt-speed replacement-sd seat-edge depth-sd view-slope scale-sd event-sd frame-tissue
        cuff-softest cuff-stiffest""",
    "export": """threads bar-width pin-diameter bore-clearance layer-gap clearance cuff-hole-diameter cuff-hole-spacing
        actuator-diameter actuator-eye actuator-mass rod-diameter""",
    "gait": "threads cutoff age placement-sd",
    "live": "threads tolerance port patience least-free",
    "loads": "threads share rise-time draws seed-number",
    "optimize": """threads grashof-margin singularity-margin assist starts certify yield round max-force max-pin-force
        max-mount-force safety-factor knee-torque min-moment-arm min-transmission max-angle max-length robust
        clear-seat clear-limb thigh shank certify-time""",
    "run": "threads",
    "simulate": "threads d-min d-max angles stroke rows thigh-link-mass shank-link-mass max-leg-shear max-cuff-force",
    "stroke": """threads speed from-angle to-angle smooth hold margin max-speed max-acceleration dead-time tolerance
        home-stroke home-speed command-timeout speed-tolerance home-error lag stop-travel extend-stop feedback-error
        supply current-zero current-scale max-current stall-current force-limit force-per-ampere idle-current
        speed-limit safety-relay hold-button table-tolerance""",
    "symmetry": "threads replacement-sd",
    "sync": "threads drift-sd",
    "synth": """threads repetitions hub duration width height motion-seed walk-in second-person pace rest warp skin stride
        stride-length passes begin radius radius-px distance yaw pitch roll shutter readout psf read-noise shot-gain
        start jitter level brightness exposure flicker reflections population sessions""",
    "track": "threads end",
}

# Options whose value is one of several words, given another.
CHOICES = {
    "anonymise": "rotate",
    "calibrate": "loss lens",
    "check": "polarity",
    "cohort": "movement",
    "compare": "knee walking up",
    "convert": "out-unit leg",
    "gait": "facing filter sex",
    "loads": "leg",
    "optimize": "mount",
    "stroke": "feedback",
    "synth": "scene movement markers",
    "track": "detector",
}

# What programs say of files of another kind, in the place of their first one.
TRIALS = {"empty": "neither trajectory.csv nor tracks.csv of lake-track", "text.csv": "write a table with the columns frame",
          **dict.fromkeys(("design.yaml", "camera.yaml", "study.yaml", "page.html"), "are known")}
VIDEOS = {"empty": "is a folder, not a video; for an image sequence",
          **dict.fromkeys(("text.csv", "design.yaml", "camera.yaml", "study.yaml", "page.html"), "not a video that can be read")}
DESIGNS = {"empty": "is a folder, not a file", "camera.yaml": "--camera reads it", "study.yaml": "lake run reads it",
           **dict.fromkeys(("text.csv", "page.html"), "a design is a map with the keys links, d_min_mm, …")}
READERS = {**dict.fromkeys(("axis", "compare", "convert", "gait", "loads", "symmetry", "sync"), TRIALS),
           **dict.fromkeys(("check", "track"), VIDEOS), **dict.fromkeys(("export", "simulate", "stroke"), DESIGNS)}

# Command  ->  what its message must have.
ROWS = """
anonymise empty --trial empty  ->  --trial is the folder that lake track made of the video
anonymise text.csv --trial empty  ->  --trial is the folder that lake track made of the video
anonymise design.yaml --trial empty  ->  --trial is the folder that lake track made of the video
anonymise camera.yaml --trial empty  ->  --trial is the folder that lake track made of the video
anonymise study.yaml --trial empty  ->  --trial is the folder that lake track made of the video
anonymise page.html --trial empty  ->  --trial is the folder that lake track made of the video
anonymise … --triax  ->  did you mean '--trial
axis … --windox  ->  did you mean '--window
axis … --segment odd  ->  --segment 'odd': write it as NAME=VALUE
axis … --unit odd  ->  mm, cm, m, px or its length in mm
axis … --range odd  ->  --range must have 2 numbers
calibrate … --fix-kx  ->  did you mean '--fix-k3
calibrate … --board odd  ->  see lake-calibrate --help
check … --polaritx  ->  did you mean '--polarity
check … --markers odd  ->  recordings of a leg are judged
check … --seed odd  ->  --seed 'odd': write it as NAME=VALUE
check … --crop odd  ->  --crop must have 4 numbers
cohort  ->  --template FOLDER makes one
cohort … --corex  ->  did you mean '--cores
compare  ->  human
compare … --replacement-sx  ->  did you mean '--replacement-sd
compare … --joint-at odd  ->  --joint-at must have 2 numbers
compare … --map odd  ->  --map 'odd': write it as NAME=VALUE
compare … --exo-map odd  ->  --exo-map 'odd': write it as NAME=VALUE
compare … --camera absent.xyz  ->  leave it out
compare … --scale odd  ->  --scale must have 5 numbers
compare … --depth odd  ->  --depth 'odd': write it as NAME=VALUE
compare --left trial.csv --right trial.csv  ->  lake symmetry LEFT RIGHT
compare … --exo-segment odd  ->  --exo-segment 'odd': write it as NAME=VALUE
compare … --thigh-cuff odd  ->  give DISTANCE:LENGTH in mm, as 200:80
compare … --shank-cuff odd  ->  give DISTANCE:LENGTH in mm, as 200:80
compare … --forward odd  ->  x, y or z with a sign
compare … --exo-unit odd  ->  mm, cm, m, px or its length in mm
compare … --plane-points odd  ->  leave it out
compare … --exo-camera absent.xyz  ->  leave it out
compare … --exo-scale odd  ->  --exo-scale must have 5 numbers
compare … --exo-plane-points odd  ->  leave it out
symmetry … --right-scale odd  ->  --right-scale must have 5 numbers
symmetry … --right-plane-points odd  ->  --right-plane-points has no effect
convert … --smoothex  ->  did you mean '--smoothed
convert … --crop odd  ->  --crop must have 2 numbers
export … --cuff-hole-spacinx  ->  did you mean '--cuff-hole-spacing
export … --plate odd  ->  a thickness and a material, such as 4mm,PLA
gait … --smoothex  ->  did you mean '--smoothed
gait … --technical odd  ->  --technical 'odd': write it as NAME=VALUE
gait … --angle odd  ->  --angle 'odd': write it as NAME=VALUE
gait … --distance odd  ->  --distance 'odd': write it as NAME=VALUE
gait … --speed odd  ->  --speed 'odd': write it as NAME=VALUE
gait … --range-limit odd  ->  --range-limit must have 2 numbers
gait … --compare-with odd  ->  it has: none
info empty  ->  neither trajectory.csv nor tracks.csv of lake-track
info text.csv  ->  write a table with the columns frame
info design.yaml  ->  lake calibrate makes a file from pictures of a board
info study.yaml  ->  lake calibrate makes a file from pictures of a board
info page.html  ->  are known
info … --versiox  ->  did you mean '--version
live empty --replay  ->  holds no recording of lake live
live … --joint-ax  ->  did you mean '--joint-at
live … --joint odd  ->  is not one of the markers (ankle, knee, hip, waist, exo_knee
live … --overlay odd  ->  see lake-live --help
loads … --plane-pointx  ->  did you mean '--plane-points
loads … --foot odd  ->  --foot must have 2 numbers
loads … --plates odd  ->  --plates 'odd': write it as NAME=VALUE
optimize --min-transmissiox  ->  did you mean '--min-transmission
optimize --actuator odd  ->  it has L16-50-35, L16-100-63, L16-140-150, P16-100-256, LA31
optimize --duration odd  ->  a duration (--duration, duration_s) is free or a number of s
optimize --start odd  ->  --start must have 6 numbers
optimize --rest odd  ->  --rest must be one of anywhere, standing
review text.csv  ->  not a video that can be read
review camera.yaml  ->  --camera reads it
review study.yaml  ->  lake run reads it
review page.html  ->  not a video that can be read
review … --movemenx  ->  did you mean '--movement
run  ->  --template FILE writes one to fill in
run empty  ->  is a folder, not a file
run text.csv  ->  a study is a map with the keys human, exo, camera, …
run design.yaml  ->  lake simulate, lake stroke, lake export and lake review read
run camera.yaml  ->  --camera reads it
run study.yaml  ->  files are missing
run page.html  ->  a study is a map with the keys human, exo, camera, …
run … --keep-goinx  ->  did you mean '--keep-going
run … --only odd  ->  files are missing
simulate  ->  give either a design file or --links l1,l2,l3,l4,l5,l6
simulate … --seat-edgx  ->  did you mean '--seat-edge
simulate … --links odd  ->  --links must have 6 numbers
simulate … --animation odd  ->  see lake-simulate --help
stroke … --speed-tolerancx  ->  did you mean '--speed-tolerance
stroke … --rod-markers odd  ->  --stroke-log and --rod-markers belong to --validate TRACKDIR
stroke … --pot odd  ->  give two different points COUNTS=MM,COUNTS=MM, e.g. 102=242,
stroke … --pins odd  ->  --pins 'odd': write it as NAME=VALUE
stroke … --pins odd=3  ->  ena, in1, in2, retract, extend, out1, out2
symmetry  ->  left
symmetry … --sync absent.xyz  ->  only applies together with --forces
symmetry … --right-map odd  ->  --right-map 'odd': write it as NAME=VALUE
symmetry … --plates odd  ->  --plates 'odd': write it as NAME=VALUE
sync … --signal-x  ->  did you mean '--signal-a
sync … --signal-a odd  ->  give both
sync … --signal-b odd  ->  give both
synth --stride-lengtx  ->  did you mean '--stride-length
synth --exo odd  ->  --exo must have 2 numbers
synth --extra-markers odd  ->  a drawn sit-to-stand has shank1 and shank2
synth --distortion odd  ->  --distortion must have 5 numbers
synth --hide odd  ->  --hide 'odd': write it as NAME=VALUE
track … --dictionarx  ->  did you mean '--dictionary
track … --color odd  ->  --color is for --detector color
track … --export odd  ->  there are mot, trc, c3d, tracker, trk, kinovea, kva
track … --vertical odd  ->  --vertical must have 4 numbers
export absent.yaml mjcf  ->  absent.yaml: no such file
simulate absent.yaml  ->  absent.yaml: no such file
stroke absent.yaml  ->  absent.yaml: no such file
redesign  ->  --comparison%--human
redesign --comparison empty  ->  lake-compare
redesign --human-onlx  ->  did you mean '--human-only
redesign --pareto odd  ->  --pareto must be %number
run absent.yaml  ->  absent.yaml: no such file
optimize --problem absent.yaml  ->  absent.yaml: no such file
"""


def rows():
    """The words of each command, and what its message must have."""
    for program, right in RIGHT.items():
        if right and program not in ("calibrate", "cohort", "compare", "run", "simulate", "stroke"):
            yield [program], f"is required; see lake-{program} --help"
        yield [program, *right.split(), "--no-such-option"], f"there is no option '--no-such-option'; see lake-{program} --help"
    for options, must in ((NUMBERS, "number"), (CHOICES, "one of")):
        for program, names in options.items():
            for name in names.split():
                yield [program, *RIGHT[program].split(), f"--{name}", "odd"], f"--{name} must be %{must}"
    for program, files in READERS.items():
        for file, said in files.items():
            yield [program, file, *RIGHT[program].split()[1:]], said
    for row in ROWS.strip().split("\n"):
        command, said = row.split("  ->  ")
        program, *words = command.split()
        yield [program, *(part for word in words for part in (RIGHT[program].split() if word == "…" else [word]))], said


class WrongInputs(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="lake-wrong-"))
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "empty").mkdir()
        for name in ("study.yaml", "problem.yaml", "camera.yaml"):
            shutil.copy(DATA / name, self.folder)
        shutil.copy(DATA / "worn.yaml", self.folder / "design.yaml")
        (self.folder / "text.csv").write_text("hello\nworld\n")
        (self.folder / "page.html").write_text("<html>\n<p>page</p>\n</html>\n")
        markers = ("ankle", "knee", "hip", "waist")
        header = ["frame", "time_s", *(f"{name}_{axis}_mm" for name in markers for axis in "xy")]
        lines = [[i, i / 30, *(place for up in (100, 500, 900, 1100) for place in (0, up))] for i in range(60)]
        (self.folder / "trial.csv").write_text("".join(",".join(map(str, line)) + "\n" for line in [header, *lines]))
        subprocess.run(["ffmpeg", "-v", "error", "-f", "lavfi", "-i", "color=gray:s=320x240:r=30:d=1", self.folder / "film.mp4"],
                       check=True, stdin=subprocess.DEVNULL)

    def say(self, words):
        return subprocess.run([BIN / f"lake-{words[0]}", *words[1:]], cwd=self.folder, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, timeout=WAIT_S, check=False)

    def test_each_gets_one_line_with_the_way_out(self):
        table = list(rows())
        self.assertGreaterEqual(len(table), LEAST)
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            for (words, must), done in zip(table, pool.map(lambda row: self.say(row[0]), table)):
                with self.subTest(command=" ".join(words)):
                    self.assertIn(done.returncode, (1, 2), done.stderr)
                    self.assertEqual(done.stdout, "")
                    self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
                    self.assertTrue(done.stderr.startswith(f"lake-{words[0]}: "), done.stderr)
                    for part in must.split("%"):
                        self.assertIn(part, done.stderr)


if __name__ == "__main__":
    unittest.main()
