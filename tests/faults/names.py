"""Every program on files and in folders of odd names: the tables are those of plain names, and what quotes a name is still
well-formed JSON, SVG, XML, YAML and HTML in UTF-8.

names.py INPUTS [--only NAME…]     INPUTS as programs.py makes them
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import sys
import tempfile
import xml.etree.ElementTree

import programs
from limits import files_in

ODD = {
    "blanks, quotes": "a b 'c' \"d\" $HOME `e` \\f",
    "newline, tab": "a\nb\tc",
    "leading dash": "-rf --help",
    "per cent": "100%d %s %% {} {0}",
    "brackets": "[0-9]*? {a,b}",
    "markup": "<b>&amp;<script>alert(1)<!--]]>",
    "UTF-8": "Jürgen 膝 🦵",
    "Latin-1": os.fsdecode(b"J\xfcrgen"),
    "comma, equals, colon": "a,b=c:d;e#f@g",
}


def with_names(words, name, inputs):
    """The same words with the inputs in the folder `name`."""
    return [f"./{name}/{word}" if word in inputs else word for word in words]


def malformed(name, content):
    """What is wrong with a file as its format has it, or None."""
    ending = pathlib.PurePath(name).suffix
    try:
        if ending == ".json":
            json.loads(content.decode("utf-8"))
        if ending in (".svg", ".xml", ".urdf", ".trk", ".kva"):
            xml.etree.ElementTree.fromstring(content)
        if ending in (".html", ".yaml", ".csv", ".md", ".h", ".ino", ".cpp"):  # options.toml has names byte by byte
            content.decode("utf-8")
        if ending in (".html", ".svg") and re.search(rb"<b>&amp;<script>|<script>alert", content):
            return "a name became markup"
    except (ValueError, xml.etree.ElementTree.ParseError) as error:
        return str(error)
    return None


def tables_of(files):
    """Those that name no input."""
    return {name: content for name, content in files.items()
            if name.endswith((".csv", ".mot", ".dxf", ".step")) and not name.endswith("plateaus.csv")}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("inputs", type=pathlib.Path)
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--names", nargs="*", default=list(ODD))
    asked = parser.parse_args()
    faults = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        inputs = {path.name for path in asked.inputs.iterdir()}
        shutil.copytree(asked.inputs, folder / "plain")
        for name in asked.names:
            shutil.copytree(asked.inputs, folder / ODD[name])
        for program, words in programs.commands(folder / "plain").items():
            if program not in (asked.only or [program]):
                continue
            plain = programs.run(programs.into(with_names(words, "plain", inputs), "plain/out", folder), folder)
            tables = tables_of(files_in(folder / "plain/out"))
            for name in asked.names:
                out = f"./{ODD[name]}/out"
                ended = programs.run(programs.into(with_names(words, ODD[name], inputs), out, folder), folder)
                files = files_in(folder / out)
                wrong = [f"{file}: {fault}" for file, content in files.items() if (fault := malformed(file, content))]
                if ended.returncode != plain.returncode:
                    wrong.append(f"ended with {ended.returncode}: {ended.stderr[-500:]!r}")
                elif tables_of(files) != tables:
                    wrong.append("other tables: " + ", ".join(
                        sorted(file for file in tables if tables_of(files).get(file) != tables[file])))
                for fault in wrong:
                    faults += 1
                    print(f"FAULT {program}, {name}: {fault}", flush=True)
                shutil.rmtree(folder / out, ignore_errors=True)
            shutil.rmtree(folder / "plain/out", ignore_errors=True)
            print(f"{program}: {len(asked.names)} names", flush=True)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
