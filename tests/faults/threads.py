"""Every program with one thread and with two: the same bytes in every file and on stdout.

threads.py INPUTS [--only NAME…]     INPUTS as programs.py makes them
"""
import argparse
import json
import pathlib
import re
import shutil
import sys
import tempfile

import programs
from limits import files_in


def without(value, keys):
    """A JSON value without these keys, at any depth."""
    if isinstance(value, dict):
        return {key: without(inner, keys) for key, inner in value.items() if key not in keys}
    return [without(inner, keys) for inner in value] if isinstance(value, list) else value


def comparable(files):
    """Without what says how many threads were asked for, and how long a study's steps took."""
    kept = {}
    for name, content in files.items():
        base = pathlib.PurePath(name).name
        if base == "options.toml":
            content = b"\n".join(line for line in content.splitlines() if not line.startswith(b"threads="))
        if base == "summary.json":
            summary = without(json.loads(content), ("command", "threads", "seconds"))
            content = json.dumps(summary).encode()
        if base in ("report.html", "sit_to_stand.html"):
            content = b"\n".join(line for line in content.splitlines() if b"--threads" not in line and b">option threads<" not in line)
        if not base.endswith((".lake-files.json", ".lake-step.json")):
            kept[name] = content
    return kept


def results(words, threads, folder):
    shutil.rmtree(folder / "out", ignore_errors=True)
    ended = programs.run(programs.into(words + ["--threads", str(threads)], "out", folder), folder)
    stdout = re.sub(r" +\d+\.\d s ", " ", ended.stdout)  # likewise
    return ended.returncode, stdout, comparable(files_in(folder / "out"))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("inputs", type=pathlib.Path)
    parser.add_argument("--only", nargs="*")
    asked = parser.parse_args()
    failed = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary) / "in"
        shutil.copytree(asked.inputs, folder)
        for name, words in programs.commands(folder).items():
            if name == "convert" or asked.only and name not in asked.only:
                continue
            one, two = results(words, 1, folder), results(words, 2, folder)
            differing = sorted(file for file in set(one[2]) | set(two[2]) if one[2].get(file) != two[2].get(file))
            if not one[2] or one[:2] != two[:2] or differing:
                failed.append(name)
                print(f"{name}: exit codes {one[0]} and {two[0]}, stdout {'same' if one[1] == two[1] else 'differs'}, "
                      f"{len(one[2])} files, of which differ: {', '.join(differing)}")
            else:
                print(f"{name}: {len(one[2])} files, the same")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
