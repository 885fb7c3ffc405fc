"""What libav says of a damaged film or picture, and OpenCV of a damaged camera, is said by the program, in its own words
or not at all."""
import os
import pathlib
import random
import subprocess
import tempfile
import unittest

BIN = pathlib.Path(os.environ["LAKE_BIN"])
CAMERA = pathlib.Path(__file__).resolve().parents[2] / "data/sts-study/camera.yaml"
SOURCE = "ffmpeg -v error -nostdin -y -f lavfi -i testsrc2=s=160x120:r=30:d=1"
# The options of FFmpeg by which each is made of one second.
FILMS = {
    "h264.mp4": "-c:v libx264 -preset ultrafast",
    "mpeg4.avi": "-c:v mpeg4",
}
PICTURES = {
    "picture.png": "-frames:v 1",
    "picture.jpg": "-frames:v 1",
}


def damaged(data, seed):
    """By name: ends early, is overwritten here and there in its middle third, is only a beginning."""
    rng = random.Random(seed)
    middle = bytearray(data)
    for at in range(len(data) // 3, 2 * len(data) // 3, 37):
        middle[at] = rng.randrange(256)
    return {"cut": data[:6 * len(data) // 10], "overwritten": bytes(middle), "beginning": data[:40]}


class LibraryLogs(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def make_damaged(self, files):
        for seed, (name, options) in enumerate(files.items()):
            subprocess.run([*SOURCE.split(), *options.split(), name], check=True, cwd=self.folder)
            for damage, data in damaged((self.folder / name).read_bytes(), seed).items():
                (self.folder / f"{damage}_{name}").write_bytes(data)
                yield f"{damage}_{name}"

    def expect_own_words(self, program, *words):
        done = subprocess.run([BIN / program, *words, "--quiet", "-o", "out"],
                              cwd=self.folder, capture_output=True, text=True, errors="replace", check=False)
        self.assertIn(done.returncode, (0, 1), f"{program} {words}: {done.stderr}")
        for line in done.stderr.splitlines():
            self.assertTrue(line.startswith(f"{program}: "), f"{program} {words}: {line}")

    def test_of_films(self):
        for name in self.make_damaged(FILMS):
            self.expect_own_words("lake-track", name)

    def test_of_pictures(self):
        for name in self.make_damaged(PICTURES):
            self.expect_own_words("lake-calibrate", name, "--board", "chessboard:6x4:25")

    def test_of_cameras(self):
        data = CAMERA.read_bytes()
        cameras = {f"{damage}_{seed}.yaml": text for seed in range(4) for damage, text in damaged(data, seed).items()}
        cameras["mismatched.yaml"] = b'<?xml version="1.0"?>\n<opencv_storage><a>1</b></opencv_storage>'
        cameras["open.yaml"] = b'{"camera_matrix": [1, 2'
        cameras["large.yaml"] = data.replace(b"rows: 3", b"rows: 100000").replace(b"cols: 3", b"cols: 100000")
        subprocess.run([*SOURCE.split(), *FILMS["h264.mp4"].split(), "film.mp4"], check=True, cwd=self.folder)
        for name, text in cameras.items():
            (self.folder / name).write_bytes(text)
            self.expect_own_words("lake-track", "film.mp4", "--camera", name)


if __name__ == "__main__":
    unittest.main()
