#!/usr/bin/env python3
"""Checks that modules use only what lies below them: the includes of libs/*, and the link lines of their CMakeLists.txt.

The table says for each module what it may use directly; what those use may be used too."""
import pathlib
import re
import sys

MAY_USE = {
    "core": [],
    "motion": ["core"],
    "video": ["core"],
    "linkage": ["core"],
    "nlp": ["core"],
    "camera": ["motion", "video"],
    "tracking": ["motion", "video", "camera"],
    "gait": ["motion", "camera"],
    "exchange": ["motion"],
    "compare": ["motion", "gait"],
    "render": ["motion", "video", "camera", "gait", "compare", "linkage", "synthesis", "actuator"],
    "synthesis": ["linkage", "compare", "nlp"],
    "actuator": ["linkage"],
    "synth": ["motion", "video", "camera", "linkage"],
    "report": ["render"],
    "pipeline": ["tracking", "gait", "exchange", "compare", "synthesis", "actuator", "report"],
}


def reachable(module):
    seen, todo = set(), [module]
    while todo:
        for below in MAY_USE[todo.pop()]:
            if below not in seen:
                seen.add(below)
                todo.append(below)
    return seen


def uses(folder):
    """Yields (file, line, used module) for every include and link line."""
    patterns = {".h": r'#include [<"]lake/(\w+)/', ".cc": r'#include [<"]lake/(\w+)/', ".txt": r"lake::(\w+)"}
    for path in sorted(folder.rglob("*")):
        if path.suffix in patterns:
            for number, line in enumerate(path.read_text().splitlines(), 1):
                for used in re.findall(patterns[path.suffix], line):
                    yield path, number, used


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    problems = []
    for module, below in MAY_USE.items():
        if module in reachable(module):
            problems.append(f"{module}: uses itself in a circle")
    for folder in sorted(p for p in (root / "libs").iterdir() if p.is_dir()):
        if folder.name not in MAY_USE:
            problems.append(f"{folder.relative_to(root)}: not in the table of {pathlib.Path(__file__).name}")
            continue
        allowed = reachable(folder.name) | {folder.name}
        for path, number, used in uses(folder):
            if used not in allowed:
                problems.append(f"{path.relative_to(root)}:{number}: {folder.name} may not use {used}")
    for problem in problems:
        print(problem)
    print(f"layers: {len(problems)} problems")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
