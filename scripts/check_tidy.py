#!/usr/bin/env python3
"""clang-tidy on the lines that changed: since the branch left origin/main, or in the last commit if there is no such branch
or nothing was added to it. check_tidy.py [BASE]: since BASE. Needs clang-14 and clang-tidy-14.

Of a change of more sources than LAKE_TIDY_MOST (40), such as a move, it checks those with the most changed lines, and says so."""
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys

os.chdir(pathlib.Path(__file__).resolve().parent.parent)


def git(*arguments):
    """What git says, or None if it fails."""
    done = subprocess.run(["git", *arguments], capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else None


def base():
    left = git("merge-base", "HEAD", "origin/main")
    if left and left != git("rev-parse", "HEAD"):
        return left
    return git("rev-parse", "--verify", "--quiet", "HEAD~1") or git("hash-object", "-t", "tree", "/dev/null")


def changed_lines(since):
    """File -> [first, last] of each run of lines that were added or changed."""
    lines, name = {}, ""
    for line in git("diff", "-U0", "-M", since, "--", "*.cc", "*.h").splitlines():
        if line.startswith("+++ "):
            name = line[6:]
        elif hunk := re.match(r"@@ .* \+(\d+)(?:,(\d+))? @@", line):
            first, count = int(hunk[1]), int(hunk[2] or 1)
            if count:
                lines.setdefault(name, []).append([first, first + count - 1])
    return lines


def main():
    most = int(os.environ.get("LAKE_TIDY_MOST", 40))
    since = sys.argv[1] if len(sys.argv) > 1 else base()
    lines = changed_lines(since)
    size = {name: sum(last - first + 1 for first, last in runs) for name, runs in lines.items()}
    sources = sorted((name for name in lines if re.match(r"(apps|libs)/.*\.cc$", name)), key=lambda name: -size[name])
    if len(sources) > most:
        print(f"clang-tidy: {len(sources)} sources changed: the {most} with the most changed lines are checked (LAKE_TIDY_MOST)")
        sources = sources[:most]
    for command in (["cmake", "--preset", "clang"], ["cmake", "--build", "--preset", "clang", "--target", "lake_commit"]):
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    tidy = ["clang-tidy-14", "--quiet", "-p", "build/clang",
            "--line-filter=" + json.dumps([{"name": name, "lines": runs} for name, runs in lines.items()])]

    def look_at(source):
        done = subprocess.run([*tidy, source], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if done.returncode:
            print(done.stdout + done.stderr, end="", flush=True)
        return done.returncode

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        found = sum(code != 0 for code in pool.map(look_at, sources))
    print(f"clang-tidy: {len(sources)} sources since {since[:12]}, {found} with findings")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
