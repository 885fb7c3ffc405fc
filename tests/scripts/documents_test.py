"""What the pages say is there is there: links of all Markdown files, a README for each room, tests that SAFETY.md names."""
import re
import unittest

from project import ROOT


def pages():
    return [path for path in sorted(ROOT.rglob("*.md")) if not {".git", "build", "lake-out"} & set(path.relative_to(ROOT).parts)]


def anchors(page):
    """Headings as a browser's address has them: lower case, letters, digits and hyphens."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def rooms():
    files = [path for path in sorted((ROOT / "libs").rglob("CMakeLists.txt")) if path.parent != ROOT / "libs"]
    return [path.parent for path in files if "lake_add_room(" in path.read_text()]


class Documents(unittest.TestCase):
    def test_links_lead_somewhere(self):
        self.assertGreater(len(pages()), 20)
        for page in pages():
            for link, anchor in re.findall(r"\]\(([^)#\s]*)#?([^)\s]*)\)", page.read_text()):
                if re.match(r"\w+:", link):
                    continue
                target = page.parent / link if link else page
                with self.subTest(page=page.relative_to(ROOT), link=link):
                    self.assertTrue(target.exists())
                    if anchor:
                        self.assertIn(anchor, anchors(target))

    def test_each_room_says_what_it_is(self):
        table = (ROOT / "libs/README.md").read_text()
        self.assertGreater(len(rooms()), 20)
        for room in rooms():
            with self.subTest(room=room.name):
                first, _, second = (room / "README.md").read_text().partition("\n\n")
                self.assertRegex(first, rf"\A# {room.name}: [^\n]*\Z")
                self.assertRegex(second, r"\A[A-Z`][^#|]*\.", "begins with a sentence")
                self.assertIn(f"[{room.name}]({room.relative_to(ROOT / 'libs')}/README.md)", table)

    def test_safety_names_tests_and_alarms_that_exist(self):
        safety = (ROOT / "libs/design/actuator/SAFETY.md").read_text()
        sources = "\n".join(path.read_text() for path in (ROOT / "tests").rglob("*.cc"))
        tests = {".".join(name) for name in re.findall(r"^TEST(?:_[FP])?\((\w+),\s+(\w+)", sources, re.M)}
        named = set(re.findall(r"`([A-Z]\w+\.\w+)`", safety))
        self.assertGreater(len(named), 40)
        self.assertEqual(named - tests - {"SIGN-OFF.md"}, set())
        for row in re.findall(r"^\|.*\|$", safety, re.M):
            self.assertNotRegex(row, r"`\w*[…*]|\.\*`|\| the same(?: \||[,;])")
        faults = re.findall(r"(FAULT_[A-Z_]+) = ([1-9]\d*)", (ROOT / "libs/design/actuator/firmware/state.h").read_text())
        self.assertEqual(re.findall(r"^\| (\d+) \| `(FAULT_[A-Z_]+)` \|", safety, re.M), [(number, name) for name, number in faults])


if __name__ == "__main__":
    unittest.main()
