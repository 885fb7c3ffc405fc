#!/usr/bin/env python3
"""Builds the manual: runs every command of its pages on the sample study, makes every picture of what they wrote, and renders the site with mkdocs.

    libs/present/manual/build.py [--out build/manual] [--programs build/release/bin]

The site needs no network. Pages are Markdown in pages/, in the order of mkdocs.yml, with a few lines of their own:
    ```sh                          commands, which are run, page after page, in one folder with data/ and calibration/
    {{figure FILE | caption}}      a picture that a command wrote
    {{frame VIDEO SECONDS | caption}}   a frame of a video that a command wrote
    {{story | caption}}            the picture story of story.py
    {{columns}} {{options}} {{rooms}} {{file PATH}} {{template PROGRAM}}   references made of columns.csv, --help-all, the rooms' READMEs, a file of the
                                   project, the YAML file that a program's --template writes"""
import argparse
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path[:0] = [str(ROOT / "apps/python"), str(HERE)]
import lake  # noqa: E402
import story  # noqa: E402

# What the rooms say of their methods, in the order in which data goes through them.
ROOMS = ["measure/video", "measure/camera", "measure/tracking", "measure/gait", "measure/axis", "measure/sync", "measure/loads", "measure/compare", "design/linkage", "design/problem",
         "design/nlp", "design/certificate", "design/synthesis", "design/redesign", "design/actuator", "measure/reliability", "study/cohort", "present/overlay", "measure/exchange", "study"]


def pages():
    """File names in the order of mkdocs.yml."""
    return re.findall(r"^ *- .*?: *(\w[\w-]*\.md)$", (HERE / "mkdocs.yml").read_text(encoding="utf-8"), re.M)


def commands(text):
    return [block for block in re.findall(r"^```sh\n(.*?)^```$", text, re.M | re.S)]


class Manual:
    def __init__(self, programs, work, docs):
        self.work, self.docs = work, docs
        self.programs = sorted(path.name.removeprefix("lake-") for path in programs.glob("lake-*") if os.access(path, os.X_OK))
        self.environment = {**os.environ, "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": str(ROOT / "apps/python")}
        for name in ("data", "calibration"):
            (work / name).symlink_to(ROOT / name)
        (docs / "pictures").mkdir(parents=True)

    def run(self, page, block):
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", block], cwd=self.work, env=self.environment, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, check=False)
        if done.returncode != 0:
            sys.exit(f"build.py: {page}: exit code {done.returncode} of\n{block}{done.stdout}")

    def picture(self, source, name, caption):
        if not source.is_file():
            sys.exit(f"build.py: {source}: there is no such picture")
        shutil.copyfile(source, self.docs / "pictures" / name)
        return f"![{caption}](pictures/{name})\n\n*{caption}*"

    def figure(self, match):
        return self.picture(self.work / match[1], match[1].replace("/", "-"), match[2])

    def frame(self, match):
        name = match[1].replace("/", "-").replace(".", "-") + f"-{match[2].replace('.', '_')}.png"
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-nostdin", "-ss", match[2], "-i", self.work / match[1], "-frames:v", "1", self.work / name],
                       check=True)
        return self.picture(self.work / name, name, match[3])

    def story(self, match):
        story.draw(self.work, self.work / "story.png")
        return self.picture(self.work / "story.png", "story.png", match[1])

    def options(self, _):
        parts = []
        for program in self.programs:
            said = subprocess.run(["lake", program, "--help-all"], env=self.environment, text=True, stdout=subprocess.PIPE, check=True).stdout
            parts.append(f"## lake {program}\n\n```text\n{said.strip()}\n```\n")
        return "\n".join(parts)

    def room(self, folder):
        """A README under a heading one step lower, without links that lead out of the manual."""
        text = (ROOT / "libs" / folder / "README.md").read_text(encoding="utf-8")

        def image(match):
            name = folder.replace("/", "-") + "-" + pathlib.Path(match[2]).name
            return self.picture(ROOT / "libs" / folder / match[2], name, match[1]).split("\n")[0]

        text = re.sub(r"!\[([^\]]*)\]\(([^)]+)\)", image, text)
        text = self.unlinked(text)
        return re.sub(r"^(#+ )", r"#\1", text, flags=re.M)

    @staticmethod
    def unlinked(text):
        return re.sub(r"(?<!!)\[([^\]]*)\]\((?!\w+:)[^)]*\)", r"\1", text)

    def template(self, match):
        """The YAML file that a program writes to be filled in."""
        path = self.work / f"template-{match[1]}.yaml"
        subprocess.run(["lake", match[1], "--template", path], env=self.environment, check=True)
        return path.read_text(encoding="utf-8").rstrip()

    def file(self, match):
        text = (ROOT / match[1]).read_text(encoding="utf-8").rstrip()
        return self.unlinked(text) if match[1].endswith(".md") else text

    def write(self, page):
        text = (HERE / "pages" / page).read_text(encoding="utf-8")
        for block in commands(text):
            self.run(page, block)
        text = re.sub(r"^\{\{figure (\S+) \| (.*)\}\}$", self.figure, text, flags=re.M)
        text = re.sub(r"^\{\{frame (\S+) (\S+) \| (.*)\}\}$", self.frame, text, flags=re.M)
        text = re.sub(r"^\{\{story \| (.*)\}\}$", self.story, text, flags=re.M)
        text = re.sub(r"^\{\{columns\}\}$", lambda _: columns(), text, flags=re.M)
        text = re.sub(r"^\{\{options\}\}$", self.options, text, flags=re.M)
        text = re.sub(r"^\{\{rooms\}\}$", lambda _: "\n".join(self.room(folder) for folder in ROOMS), text, flags=re.M)
        text = re.sub(r"^\{\{template (\S+)\}\}$", self.template, text, flags=re.M)
        text = re.sub(r"^\{\{file (\S+)\}\}$", self.file, text, flags=re.M)
        left = re.findall(r"\{\{.*?\}\}", text)
        if left:
            sys.exit(f"build.py: {page}: {left[0]}: not understood")
        (self.docs / page).write_text(text, encoding="utf-8")


def search_index(docs):
    """Every section of the pages, for search.js: page, anchor as mkdocs makes it, heading, text."""
    from markdown.extensions.toc import slugify  # comes with mkdocs
    sections = []
    for page in pages():
        anchors, fenced = {}, False
        for line in (docs / page).read_text(encoding="utf-8").splitlines():
            fenced ^= line.startswith("```")
            heading = None if fenced else re.match(r"#+ +(.*)", line)
            if heading:
                title = re.sub(r"[`*]", "", heading[1])
                slug = slugify(title, "-")
                anchors[slug] = anchors.get(slug, -1) + 1
                sections.append({"page": page.replace(".md", ".html"), "anchor": slug + (f"_{anchors[slug]}" if anchors[slug] else ""), "title": title, "text": ""})
            elif sections:
                sections[-1]["text"] += re.sub(r"[`*|]+", " ", line) + " "
    return f"const lakeSearchIndex = {json.dumps(sections, ensure_ascii=False)};\n"


def columns():
    parts = []
    for table in dict.fromkeys(column.table for column in lake.columns_of()):
        of_table = lake.columns_of(table)
        heads = ["column", "unit", "meaning"] + ["source"] * any(column.source for column in of_table)
        parts.append(f"\n### {table}.csv\n\n| {' | '.join(heads)} |\n|{' --- |' * len(heads)}")
        for column in of_table:
            cells = [f"`{column.column}`", column.unit, column.meaning, column.source]
            parts.append(f"| {' | '.join(cells[:len(heads)])} |")
    return "\n".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/manual", help="folder for the site")
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/release/bin", help="folder of lake and its fellows")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        site = pathlib.Path(temporary) / "site"
        work = pathlib.Path(temporary) / "work"
        work.mkdir()
        manual = Manual(options.programs.resolve(), work, site / "docs")
        for page in pages():
            manual.write(page)
        shutil.copy(HERE / "mkdocs.yml", site)
        for name in ("search.js", "search.css"):
            shutil.copy(HERE / name, site / "docs")
        (site / "docs/search-index.js").write_text(search_index(site / "docs"), encoding="utf-8")
        out = options.out.resolve()
        done = subprocess.run(["mkdocs", "build", "--quiet", "--strict", "--clean", "--site-dir", out], cwd=site, check=False)
        if done.returncode != 0:
            sys.exit("build.py: mkdocs failed")
        print(out / "index.html")


if __name__ == "__main__":
    main()
