"""What the pages say is there is there: links of all Markdown files, and a README for each room."""
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


if __name__ == "__main__":
    unittest.main()
