#!/usr/bin/env python3
"""Checks that data flows one way through the rooms of libs/.

A room is a folder with a CMakeLists.txt that calls lake_add_room. Its link lines say which rooms it uses: these lie in its own
band or in a band below, and never lead in a circle. What a file includes must be a room that the link lines reach.

check_layers.py [FOLDER]: the project's folder, if not the one that the script lies in."""
import pathlib
import re
import sys

# From the bottom up. Nothing in libs/ uses the last, which makes recordings for tests.
BANDS = ["base", "measure", "design", "present", "commands", "study", "synth"]


class Room:
    def __init__(self, folder, libs):
        self.folder = folder
        self.band = folder.relative_to(libs).parts[0]
        self.build_file = folder / "CMakeLists.txt"
        text = re.sub(r"#.*", "", self.build_file.read_text())
        self.name = re.search(r"lake_add_room\((\w+)", text).group(1)
        # Used room -> line that links it.
        self.uses = {used: number for number, line in enumerate(text.splitlines(), 1)
                     for used in re.findall(r"lake::(\w+)", line) if used != self.name}


def find_rooms(libs):
    files = [f for f in sorted(libs.rglob("CMakeLists.txt")) if f.parent != libs]
    return {room.name: room for room in (Room(f.parent, libs) for f in files if "lake_add_room(" in f.read_text())}


def reachable(name, rooms):
    seen, todo = set(), [name]
    while todo:
        for used in rooms[todo.pop()].uses:
            if used in rooms and used not in seen:
                seen.add(used)
                todo.append(used)
    return seen


def check_links(room, rooms):
    for used, number in room.uses.items():
        where = f"{room.build_file}:{number}"
        if used not in rooms:
            yield f"{where}: {room.name} links lake::{used}, which is no room"
        elif BANDS.index(rooms[used].band) > BANDS.index(room.band):
            yield f"{where}: {room.name} (band {room.band}) may not use {used} (band {rooms[used].band})"
        elif rooms[used].band == "synth":
            yield f"{where}: {room.name} may not use synth: it is for tests and the sample study only"
    if room.name in reachable(room.name, rooms):
        yield f"{room.build_file}: {room.name} uses itself in a circle"


def sources(room, rooms):
    """Yields the room's own files, not those of a room that lies in one of its folders."""
    inner = [r.folder for r in rooms.values() if r.folder != room.folder and room.folder in r.folder.parents]
    for path in sorted(room.folder.rglob("*")):
        if path.suffix in (".h", ".cc") and not any(folder in path.parents for folder in inner):
            yield path


def check_includes(room, rooms):
    allowed = reachable(room.name, rooms) | {room.name}
    for path in sources(room, rooms):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            for used in re.findall(r'#include [<"]lake/(\w+)/', line):
                if used not in allowed:
                    yield f"{path}:{number}: {room.name} may not use {used}: its link lines do not reach it"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent)
    rooms = find_rooms(root / "libs")
    problems = [p for room in rooms.values() for p in (*check_links(room, rooms), *check_includes(room, rooms))]
    for problem in problems:
        print(problem)
    print(f"layers: {len(rooms)} rooms, {len(problems)} problems")
    return 1 if problems or not rooms else 0


if __name__ == "__main__":
    sys.exit(main())
