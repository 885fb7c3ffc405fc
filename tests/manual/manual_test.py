"""The manual is built by its script: every command runs, every picture is there, and the site needs no network."""
import html.parser
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
MANUAL = ROOT / "libs/present/manual"
sys.path.insert(0, str(MANUAL))
import build  # noqa: E402


class Page(html.parser.HTMLParser):
    """What a browser fetches for a page, where its links lead, and what they may lead to."""

    def __init__(self, path):
        super().__init__()
        self.fetched, self.links, self.ids, self.text = [], [], set(), path.read_text(encoding="utf-8")
        self.feed(self.text)

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.ids.add(attrs.get("id"))
        if tag in ("script", "img", "source", "iframe") and attrs.get("src"):
            self.fetched.append(attrs["src"])
        if tag == "link" and attrs.get("rel") in ("stylesheet", "icon", "preload"):
            self.fetched.append(attrs["href"])
        if tag == "a" and attrs.get("href"):
            self.links.append(attrs["href"])


class Keys(unittest.TestCase):
    def test_those_of_a_design_and_of_a_cohort_are_on_their_page(self):
        # The other files' templates are made of the options themselves (StudyTemplate, ProblemTemplate, CameraKeys).
        page = (MANUAL / "pages/keys.md").read_text(encoding="utf-8")
        for reader, places in {"libs/design/linkage/src/design_file.cc": [page],
                               "libs/study/cohort/src/cohort_file.cc": [page, (ROOT / "libs/study/cohort/data/template/cohort.yaml").read_text(encoding="utf-8")]}.items():
            keys = re.findall(r'\.(?:Child|Text|Number|Numbers)\("(\w+)"', (ROOT / reader).read_text(encoding="utf-8"))
            self.assertGreater(len(keys), 5, reader)
            for key in keys:
                with self.subTest(reader=reader, key=key):
                    self.assertTrue(any(re.search(rf"\b{key}\b", place) for place in places))


@unittest.skipUnless(shutil.which("mkdocs"), "mkdocs is not installed (mkdocs-material)")
class Manual(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.site = pathlib.Path(cls.temporary.name) / "site"
        done = subprocess.run([sys.executable, "-B", MANUAL / "build.py", "--programs", os.environ["LAKE_BIN"], "--out", cls.site], text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        if done.returncode != 0:
            raise AssertionError(done.stdout)
        cls.pages = {path.name: Page(path) for path in cls.site.glob("*.html") if path.name != "404.html"}

    def test_each_page_is_in_the_site_and_each_file_is_a_page(self):
        self.assertEqual({page.replace(".md", ".html") for page in build.pages()}, set(self.pages))
        self.assertEqual(set(build.pages()), {path.name for path in (MANUAL / "pages").glob("*.md")})

    def test_nothing_is_fetched_from_elsewhere_and_all_that_is_fetched_is_there(self):
        for name, page in self.pages.items():
            self.assertGreater(len(page.fetched), 2)
            for target in page.fetched:
                with self.subTest(page=name, target=target):
                    self.assertNotRegex(target, r"^(\w+:)?//")
                    self.assertTrue((self.site / target.partition("?")[0]).is_file())
        for sheet in self.site.rglob("*.css"):
            self.assertNotRegex(sheet.read_text(encoding="utf-8"), r"(@import|url\()\s*[\"']?(https?:)?//")

    def test_each_section_is_found_by_searching(self):
        index = json.loads((self.site / "search-index.js").read_text(encoding="utf-8").partition("= ")[2].rstrip(";\n"))
        self.assertGreater(len(index), 100)
        for section in index:
            self.assertIn(section["anchor"], self.pages[section["page"]].ids)
        found = [section["page"] for section in index if "noise floor" in section["text"].lower()]
        self.assertIn("method.html", found)

    def test_links_lead_somewhere(self):
        for name, page in self.pages.items():
            for link in page.links:
                target, _, anchor = link.partition("#")
                if re.match(r"\w+:", target):
                    continue
                with self.subTest(page=name, link=link):
                    self.assertTrue((self.site / target).exists() if target else True)
                    if anchor and target in ("", name):
                        self.assertIn(anchor, page.ids)

    def test_no_command_stands_outside_what_is_run(self):
        for path in (MANUAL / "pages").glob("*.md"):
            outside = re.sub(r"^```sh\n.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.M | re.S)
            self.assertNotRegex(outside, r"(?m)^(\$ *)?lake[ -]\w+ ", path.name)

    def test_the_reference_has_every_table_and_every_program(self):
        for table in {column.table for column in build.lake.columns_of()}:
            self.assertIn(f"{table}.csv", self.pages["formats.html"].text)
        programs = {path.name.replace("lake-", "") for path in pathlib.Path(os.environ["LAKE_BIN"]).glob("lake-*") if os.access(path, os.X_OK)}
        for program in programs:
            self.assertIn(f"lake-{program} [OPTIONS]", self.pages["options.html"].text)


if __name__ == "__main__":
    unittest.main()
