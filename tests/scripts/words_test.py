"""What the programs and pages say is said plainly: sentences that puzzled their readers are gone, and what took their place is there."""
import re
import unittest

from project import ROOT

# What was said, and what is said instead; "{}" stands for what is put in.
INSTEAD = {
    "would have none of it": "Moving the joint onto the knee removes this part",
    "more range would lower the misalignment": "With {}° of range it would be {} %.",
    "N for {} at the knee": "To hold {} the actuator pushes with at most {}",
    "recording resolves no less": "a recording shows only noise",
    "sensitivities are not reported": "no sensitivities: several limits bind at once",
    "its speed decides": "its speed is the limit, at ",
    "the design's under its stroke program": "Knee angle of the person and of the new design.",
    "which ends what the drift": "the extend end stop, which catches the drift",
    "miss a triangle": "l1 or l4 is too short",
    "white to the limit": "no marker is overexposed",
    "times a segment's length": "the movement is large enough (",
}
ONE_NAME = {"relative error": "misalignment"}


def said():
    """The texts in the sources, those that go over several lines as one."""
    for folder in ("libs", "apps"):
        for ending in ("cc", "h", "ts", "js", "py"):
            for file in sorted((ROOT / folder).rglob(f"*.{ending}")):
                whole = re.sub(r'"\s*\n\s*"', "", file.read_text())
                for text in re.findall(r'"((?:[^"\\\n]|\\.)*)"|`([^`]*)`', whole):
                    yield file.relative_to(ROOT), "".join(text)


class Words(unittest.TestCase):
    def test_each_sentence_that_was_rewritten_stays_so(self):
        texts = list(said())
        self.assertGreater(len(texts), 5000)
        for was, instead in {**INSTEAD, **ONE_NAME}.items():
            with self.subTest(was=was):
                self.assertEqual([f"{file}: {text}" for file, text in texts if was.lower() in text.lower()], [])
                if was not in ONE_NAME:
                    self.assertTrue([text for _, text in texts if instead in text], f"nobody says: {instead}")

    def test_no_number_is_written_as_a_power_of_ten(self):
        """What the commands, the rooms of design and of base print has SignificantText's digits (core/uncertain_text.h), but for
        signed ones and for what is said of the solver's own numbers."""
        places = ("libs/base/", "libs/design/", "libs/commands/", "apps/")
        self.assertEqual([f"{file}: {text}" for file, text in said() if str(file).startswith(places)
                          and re.search(r"\{:[^{}+]*\.\d[ge]\}", text) and "KKT error" not in text], [])


if __name__ == "__main__":
    unittest.main()
