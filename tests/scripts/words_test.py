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
    "sensitivities are not reported": "no sensitivities: the limits that bind depend on one another",
    "its speed decides": "its speed is the limit, at ",
    "the design's under its stroke program": "Knee angle of the person and of the new design.",
    "which ends what the drift": "the extend end stop, which catches the drift",
    "miss a triangle": "l1 or l4 is too short",
    "white to the limit": "no marker is overexposed",
    "times a segment's length": "the movement is large enough (",
}
# Words that puzzle a reader of the field's papers, with those to use instead (architecture.md, "Words").
HOUSE_WORDS = {
    r"told": "predicted, detected, distinguished, reported",
    r"things?|spots?": "detection, marker, place on the skin",
    r"passages?|stretch(?:es)?": "interval, frames 120 to 180",
    r"stray(?:s|ed)?|jolts?|lone": "outlier, jump, isolated",
    r"manieth": "every n-th",
}
ONE_NAME = {"relative error": "misalignment", "stand-up": "rise"}


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

    def test_no_message_has_a_house_word(self):
        """Names, such as a page's "#spots button", are no messages."""
        messages = [(file, text) for file, text in said() if re.search(r"[A-Za-z]{2,} [A-Za-z]{2,}", text) and not text.startswith("#")]
        self.assertGreater(len(messages), 3000)
        for word, instead in HOUSE_WORDS.items():
            with self.subTest(word=word, instead=instead):
                self.assertEqual([f"{file}: {text}" for file, text in messages if re.search(rf"\b(?:{word})\b", text, re.I)], [])

    def test_names_and_comments_have_the_words_of_the_pages(self):
        """But for the columns of files, whose names are kept ("relative_error")."""
        for folder in ("libs", "apps"):
            for ending in ("cc", "h", "ts", "js", "md"):
                for file in sorted((ROOT / folder).rglob(f"*.{ending}")):
                    text = re.sub(r'"[^"\n]*"', "", file.read_text())
                    self.assertEqual(re.findall(r"(?i)relative.?error\w*|stand-?ups?\b", text), [], file.relative_to(ROOT))

    def test_no_number_is_written_as_a_power_of_ten(self):
        """What programs and pages say has SignificantText's digits (core/uncertain_text.h), but for the solver's own numbers."""
        self.assertEqual([f"{file}: {text}" for file, text in said()
                          if re.search(r"\{:[^{}]*\.\d[ge]\}", text) and "KKT error" not in text], [])

    def test_no_number_has_more_digits_than_its_uncertainty(self):
        """Where both are said, PlusMinusText rounds both; what is planned, not measured, has the digits of a drawing."""
        planned = ("the drift may carry", "the drift was accepted", "drift: with speeds")
        self.assertEqual([f"{file}: {text}" for file, text in said()
                          if re.search(r"\{:[^{}]*f\}[^{}]{0,3} ± \{:", text) and not text.startswith(planned)], [])


if __name__ == "__main__":
    unittest.main()
