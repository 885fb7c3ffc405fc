"""The inputs of lake live that are cameras: over RTSP, HTTP, UDP, and V4L2.

None is there where the tests run. What sends RTSP and HTTP are servers of this file's, the datagrams are sent from here, and what
is taken for a V4L2 camera is v4l2_camera.cc, preloaded (LAKE_V4L2_CAMERA: where it is)."""
import contextlib
import errno
import http.server
import itertools
import json
import math
import os
import pathlib
import re
import socket
import struct
import subprocess
import threading
import time
import unittest

import live_test
from live_test import WAIT_S, ffmpeg, frames_of, read_table

CAMERA = os.environ.get("LAKE_V4L2_CAMERA")


def code(film, to, *words):
    """As cameras send: no B-frames, a key frame twice a second."""
    ffmpeg("-i", film, "-c:v", "libx264", "-g", 15, "-bf", 0, "-crf", 18, *words, to)


class RtspCamera:
    """Plays a film over TCP to one client after the other, each time from its beginning: what ffmpeg's RTSP muxer made of it.

    `loses` says of a packet's number whether it is left out, as by a camera whose connection is too slow."""

    def __init__(self, film, loses=lambda number: False):
        self.loses = loses
        self.server = socket.create_server(("127.0.0.1", 0))
        self.url = f"rtsp://127.0.0.1:{self.server.getsockname()[1]}/film"
        self.description, self.packets = b"", []  # (channel, packet)
        self.asked_for = []  # transports
        sender = subprocess.Popen(["ffmpeg", "-v", "error", "-nostdin", "-i", film, "-c", "copy", "-f", "rtsp",
                                   "-rtsp_transport", "tcp", self.url], stderr=subprocess.PIPE, text=True)
        self.server.settimeout(WAIT_S)
        try:
            self.talk(self.server.accept()[0])
        except TimeoutError as late:
            sender.kill()
            raise AssertionError(sender.stderr.read()) from late
        self.server.settimeout(None)
        assert (sender.wait(WAIT_S), sender.stderr.read()) == (0, "")
        sender.stderr.close()
        self.serving = threading.Thread(target=self.serve, daemon=True)
        self.serving.start()

    def serve(self):
        try:
            while True:
                self.talk(self.server.accept()[0])
        except OSError:  # closed
            pass

    def close(self):
        self.server.shutdown(socket.SHUT_RDWR)
        self.server.close()
        self.serving.join(WAIT_S)

    def talk(self, connection):
        with connection, connection.makefile("rb") as lines:
            while first := lines.read(1):
                if first == b"$":
                    channel, size = struct.unpack(">BH", lines.read(3))
                    self.packets.append((channel, lines.read(size)))
                elif not self.answer(connection, (first + lines.readline()).decode(), lines):
                    break

    def answer(self, connection, request, lines):
        fields = {}
        while line := lines.readline().decode().strip():
            name, _, value = line.partition(":")
            fields[name.lower()] = value.strip()
        body = lines.read(int(fields.get("content-length", 0)))
        method, more, content = request.split()[0], "", b""
        status = "200 OK"
        if method == "ANNOUNCE":
            self.description = body
        elif method == "DESCRIBE":
            content = self.description
            more = "Content-Type: application/sdp\r\n"
        elif method == "SETUP":
            self.asked_for.append(fields["transport"])
            if "TCP" in fields["transport"]:
                more = f"Transport: {fields['transport']}\r\n"
            else:
                status = "461 Unsupported transport"
        elif method == "OPTIONS":
            more = "Public: OPTIONS, DESCRIBE, ANNOUNCE, SETUP, PLAY, RECORD, TEARDOWN\r\n"
        connection.sendall((f"RTSP/1.0 {status}\r\nCSeq: {fields['cseq']}\r\nSession: 38\r\n{more}"
                            f"Content-Length: {len(content)}\r\n\r\n").encode() + content)
        if method == "PLAY":
            for number, (channel, packet) in enumerate(self.packets):
                if channel != 0 or not self.loses(number):
                    connection.sendall(struct.pack(">cBH", b"$", channel, len(packet)) + packet)
            connection.shutdown(socket.SHUT_WR)  # the end; what the client still says is read, so that nothing is lost
        return method != "TEARDOWN"


class Datagrams:
    """Sends to a port from which somebody reads, and not more than he takes: nothing is lost on a busy machine either."""

    def __init__(self, data):
        self.data = data
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        # Kept for who asks for reuse. Being its own peer, this socket gets none of the datagrams itself.
        self.reserved = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.reserved.bind(("127.0.0.1", 0))
        self.reserved.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.reserved.connect(self.reserved.getsockname())
        self.port = self.reserved.getsockname()[1]
        self.url = f"udp://127.0.0.1:{self.port}?reuse=1"
        self.socket.connect(("127.0.0.1", self.port))
        self.sending = threading.Thread(target=self.send, daemon=True)

    def waiting_bytes(self):
        """In the reader's socket; None: there is none."""
        for line in pathlib.Path("/proc/net/udp").read_text().splitlines()[1:]:
            words = line.split()
            if words[1] in (f"0100007F:{self.port:04X}", f"00000000:{self.port:04X}") and words[2] == "00000000:0000":
                return int(words[4].partition(":")[2], 16)
        return None

    def send(self):
        size = 7 * 188
        most_bytes = 40_000  # of some 200 000 that the kernel keeps
        for at in range(0, len(self.data), size):
            end = time.monotonic() + WAIT_S
            while (waiting := self.waiting_bytes()) is None or waiting > most_bytes:
                if time.monotonic() > end:
                    return
                time.sleep(0.002)
            self.socket.send(self.data[at:at + size])

    def close(self):
        self.sending.join(WAIT_S)
        self.socket.close()
        self.reserved.close()


class HttpCamera(http.server.BaseHTTPRequestHandler):
    """Motion JPEG over HTTP, picture after picture in one answer, as web cameras and phones send it; then it hangs up."""

    pictures = []

    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=picture")
        self.end_headers()
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):  # a reader that has gone
            for picture in self.pictures:
                self.wfile.write(b"--picture\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n%b\r\n" % (len(picture), picture))

    def log_message(self, *_):
        pass


class Network(live_test.Films):
    def test_motion_jpeg_over_http(self):
        """Such a stream has no time stamps: they are counted at the rate that is said, and without one it says so."""
        stills = self.folder / "stills"
        stills.mkdir()
        ffmpeg("-i", self.film, "-c:v", "mjpeg", "-q:v", 3, "-pix_fmt", "yuvj420p", stills / "%05d.jpg")
        camera = type("Camera", (HttpCamera,), {"pictures": [still.read_bytes() for still in sorted(stills.iterdir())]})
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), camera)
        serving = threading.Thread(target=server.serve_forever, daemon=True)
        serving.start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        address = f"http://127.0.0.1:{server.server_port}/video"
        ended, _, err = self.live(address, "-o", "rateless").end()
        self.assertEqual(ended, 1)
        self.assertIn("--rate", err)
        ended, _, err = self.live(address, "--rate", 30, "-o", "http", *self.seeds()).end()
        self.assertEqual(ended, 0, err)
        self.expect_trial(self.folder / "http", self.frames, 2)
        rows = read_table(self.folder / "http/live_tracks.csv")
        for number, row in enumerate(rows):
            self.assertAlmostEqual(float(row["time_s"]), number / 30, delta=1e-6)

    def test_rtsp(self):
        """Every picture is recorded as it was sent, and looked at."""
        code(self.film, self.folder / "sent.mp4")
        camera = RtspCamera(self.folder / "sent.mp4")
        self.addCleanup(camera.close)
        ended, _, err = self.live(camera.url, "-o", "rtsp", *self.seeds()).end()  # named at once, however slow it goes
        self.assertEqual(ended, 0, err)
        self.assertIn("TCP", camera.asked_for[-1])
        live = self.expect_trial(self.folder / "rtsp", self.frames, 2)
        self.assertEqual((live["missing_frames"], live["ended"]), (0, "the stream ended"))
        self.assertEqual(hashes_of(self.folder / "rtsp/video.mkv"), hashes_of(self.folder / "sent.mp4"))
        sent_s, told_s = ([float(row["time_s"]) for row in read_table(self.folder / table)]
                          for table in ("worn/truth.csv", "rtsp/live_tracks.csv"))
        for sent, told in zip(sent_s, told_s):
            self.assertAlmostEqual(sent - sent_s[0], told, delta=1.1 / 90000)  # RTP's clock

    def test_rtsp_with_losses(self):
        """What is told comes of pictures that are as they were sent; the others are counted."""
        code(self.film, self.folder / "lossy.mp4")
        camera = RtspCamera(self.folder / "lossy.mp4", lambda number: number > 300 and number % 97 == 0)
        self.addCleanup(camera.close)
        ended, _, err = self.live(camera.url, "-o", "lossy").end()
        self.assertEqual(ended, 1)  # lake track takes no damaged recording
        self.assertIn("the recording is whole", err)
        live = json.loads((self.folder / "lossy/live.json").read_text())
        self.assertGreater(live["damaged_frames"] + live["missing_frames"], 0)
        truth = read_table(self.folder / "worn/truth.csv")
        rows = read_table(self.folder / "lossy/live_tracks.csv")
        self.assertGreater(len(rows), 0.3 * len(truth))
        for row in rows:
            there = truth[round(30 * float(row["time_s"]))]
            if row["hip_status"] == "detected":
                away_px = [float(row[f"hip_{axis}_px"]) - float(there[f"hip_{axis}_px"]) for axis in "xy"]
                self.assertLess(math.hypot(*away_px), 0.5, row["frame"])  # that of a picture earlier is 8 px away


def hashes_of(film):
    """Of its pictures."""
    shown = live_test.run("ffmpeg", "-v", "error", "-nostdin", "-i", film, "-vsync", "passthrough", "-f", "framehash", "-hash", "md5", "-")
    return [line.split(",")[-1].strip() for line in shown.stdout.splitlines() if not line.startswith("#")]


class OnThePage(live_test.Browser):
    def test_udp(self):
        """A camera that sends datagrams, watched on the page; its silence is the end."""
        code(self.film, self.folder / "datagrams.ts", "-f", "mpegts")
        camera = Datagrams((self.folder / "datagrams.ts").read_bytes())
        self.addCleanup(camera.close)
        camera.sending.start()
        live = self.live(camera.url, "--patience", 20, "-o", "udp")
        self.browser.get(live.address)
        self.until(lambda: self.part("live-picture").get_attribute("data-frame"))
        self.until(lambda: len(live.ask("state")["rises"]) == 2)
        self.until(lambda: re.fullmatch(self.MOVE, self.part("live-move").text))
        self.shot("udp")
        state = self.until(lambda: (now := live.ask("state"))["phase"] in ("done", "failed") and now)
        self.assertEqual(state["failed"], "")
        self.until(lambda: "differ from the trial" in self.part("live-difference").text)
        self.browser.get("about:blank")
        ended, _, err = live.end()
        self.assertEqual(ended, 0, err)
        told = json.loads((self.folder / "udp/live.json").read_text())
        self.assertEqual((told["damaged_frames"], told["missing_frames"]), (0, 0))
        self.assertEqual(frames_of(self.folder / "udp/video.mkv"), told["frames"])
        self.assertGreaterEqual(told["frames"], self.frames - 10)  # the last ones are in libav's buffers until more comes
        self.assertLess(told["difference"]["rms_px"], 0.1)
        self.expect_place(told["place"], live_test.WORN)


@unittest.skipIf(CAMERA is None, "no V4L2 camera: LAKE_V4L2_CAMERA")
class Device(live_test.Films):
    """/dev/zero, of which the preloaded library makes a camera of 1280x720 at 30 Hz."""

    DEVICE = "/dev/zero"

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.pictures = cls.folder / "pictures"
        cls.pictures.mkdir()
        ffmpeg("-i", cls.film, "-c:v", "mjpeg", "-q:v", 3, "-pix_fmt", "yuvj420p", cls.pictures / "%05d.jpg")
        cls.torn = 10
        (cls.pictures / f"{cls.torn + 1:05d}.jpg").write_bytes(b"")  # did not arrive whole

    def device(self, ending, *words):
        environment = dict(os.environ, LD_PRELOAD=CAMERA, LAKE_CAMERA_DEVICE=self.DEVICE, LAKE_CAMERA_PICTURES=str(self.pictures),
                           LAKE_CAMERA_SIZE="1280x720", LAKE_CAMERA_RATE="30", LAKE_CAMERA_END=str(ending))
        chosen = {"--size": "1280x720", "--rate": "30", "--format": "mjpeg"}
        chosen.update(dict(zip(words[:-2:2], words[1:-2:2])))
        return self.live(self.DEVICE, *itertools.chain(*chosen.items()), *words[-2:], env=environment)

    def expect_all(self, folder):
        live = json.loads((self.folder / folder / "live.json").read_text())
        self.assertEqual((live["frames"], live["missing_frames"], live["damaged_frames"]), (self.frames - 1, 1, 0))
        self.assertEqual(frames_of(self.folder / folder / "video.mkv"), self.frames - 1)
        self.assertLess(live["difference"]["rms_px"], 0.1)
        self.expect_place(live["place"], live_test.WORN)
        rows = read_table(self.folder / folder / "live_tracks.csv")
        for number, row in enumerate(rows):  # the camera's own stamps, in whole microseconds
            self.assertAlmostEqual(float(row["time_s"]), (number + (number >= self.torn)) / 30, delta=1.1e-6)
        return live

    def test_unplugged(self):
        """What was recorded until then is a trial."""
        ended, out, err = self.device(errno.ENODEV, "-o", "unplugged").end()
        self.assertEqual(ended, 0, err)
        self.assertIn("nothing comes any more (No such device)", self.expect_all("unplugged")["ended"])
        self.assertIn("Move the joint 18 mm back and 32 mm down", out)

    def test_frozen(self):
        ended, _, err = self.device(0, "--patience", 2, "-o", "frozen").end()
        self.assertEqual(ended, 0, err)
        self.assertIn("nothing has come for 2 s", self.expect_all("frozen")["ended"])

    def test_errors_say_what_to_do(self):
        for words, text in ((("--size", "640x480"), "--size 640x480; the nearest is 1280x720"),
                            (("--rate", 60), "--rate 60 Hz; the nearest is 30 Hz"),
                            (("--size", "large"), "no video that can be read comes from it"),
                            (("--format", "h264"), "no video that can be read comes from it")):
            ended, _, err = self.device(0, *words, "-o", "wrong").end()
            self.assertEqual((ended, len(err.splitlines())), (1, 1), err)
            self.assertIn(text, err)


class NoDevice(live_test.Films):
    def test_errors_say_what_to_do(self):
        for device, text in (("/dev/video38", "no such device or file"), ("/dev/null", "no video that can be read comes from it")):
            ended, _, err = self.live(device, "-o", "wrong").end()
            self.assertEqual((ended, len(err.splitlines())), (1, 1), err)
            self.assertIn(text, err)


if __name__ == "__main__":
    unittest.main()
