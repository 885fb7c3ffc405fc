#!/usr/bin/env python3
"""Checks that data flows one way through the rooms of libs/.

A room is a folder with a CMakeLists.txt that calls lake_add_room. Its link lines say which rooms it uses: these lie in its own
layer or in a layer below, and never lead in a circle. What a file includes must be a room that the link lines reach, a public
header by PUBLIC links alone, and nothing by a relative path. A room's public headers are in include/lake/ROOM, its names in
the namespace lake::ROOM (core's in lake), and no source lies outside a room.

check_layers.py [FOLDER]: the project's folder, if not the one that the script lies in."""
import pathlib
import re
import sys

# From the bottom up. Nothing uses the last, which makes recordings for tests.
LAYERS = ["base", "measure", "design", "present", "commands", "study", "synth"]
SOURCES = (".h", ".cc", ".c", ".ino")


class Room:
    def __init__(self, build_file, libs):
        self.folder = build_file.parent
        self.layer = self.folder.relative_to(libs).parts[0]
        self.build_file = build_file
        text = re.sub(r"#.*", "", build_file.read_text())
        self.name = re.search(r"lake_add_room\((\w+)", text).group(1)
        self.uses = {}  # used room -> line that links it
        self.public = set()  # those of them that who links this room may include too
        scope = "PUBLIC"
        for number, line in enumerate(text.splitlines(), 1):
            # A target's own name, lake_ROOM, links as its alias lake::ROOM does.
            for word, alias, target in re.findall(r"\b(PUBLIC|PRIVATE|INTERFACE|lake::(\w+)|lake_(\w+))\b", line):
                if word.isupper():
                    scope = word
                elif alias not in ("", self.name) or (target != self.name and self.is_room(target, libs)):
                    self.uses.setdefault(alias or target, number)
                    if scope != "PRIVATE":
                        self.public.add(alias or target)

    @staticmethod
    def is_room(name, libs):
        return any((folder / "include/lake" / name).is_dir() for folder in (*libs.glob("*"), *libs.glob("*/*")))

    def is_public(self, path):
        return self.folder / "include" in path.parents


def find_rooms(libs):
    files = [f for f in sorted(libs.rglob("CMakeLists.txt")) if f.parent != libs]
    return [Room(f, libs) for f in files if "lake_add_room(" in f.read_text()]


def check_rooms(found):
    rooms = {}
    for room in found:
        if room.name in rooms:
            yield f"{room.build_file}: there is a room {room.name} already, {rooms[room.name].folder}"
        if room.layer not in LAYERS:
            yield f"{room.build_file}: {room.layer} is no layer; there are {', '.join(LAYERS)}"
        rooms[room.name] = room


def reachable(name, rooms, public_only=False):
    """What a room may include, by its own links and the public ones of what they lead to."""
    seen, todo = set(), [name]
    while todo:
        room = rooms[todo.pop()]
        for used in room.public if public_only or room.name != name else room.uses:
            if used in rooms and used not in seen:
                seen.add(used)
                todo.append(used)
    return seen


def find_circle(name, rooms):
    """The way by which a room uses itself, as names; empty if it does not."""
    ways, seen = [[name]], set()
    while ways:
        way = ways.pop(0)
        for used in rooms[way[-1]].uses:
            if used == name:
                return [*way, name]
            if used in rooms and used not in seen:
                seen.add(used)
                ways.append([*way, used])
    return []


def check_links(room, rooms):
    for used, number in room.uses.items():
        where = f"{room.build_file}:{number}"
        if used not in rooms:
            yield f"{where}: {room.name} links lake::{used}, which is no room"
        elif LAYERS.index(rooms[used].layer) > LAYERS.index(room.layer):
            yield f"{where}: {room.name} (layer {room.layer}) may not use {used} (layer {rooms[used].layer})"
    if circle := find_circle(room.name, rooms):
        yield f"{room.build_file}: {room.name} uses itself in a circle: {' -> '.join(circle)}"


def owner(path, by_folder):
    """The room that a file is of: the innermost, as a room may lie in another's folder."""
    return next((by_folder[folder] for folder in path.parents if folder in by_folder), None)


def check_source(path, room, rooms):
    if room.is_public(path) and path.relative_to(room.folder).parts[:3] != ("include", "lake", room.name):
        yield f"{path}: public headers of {room.name} are in include/lake/{room.name}"
    allowed = reachable(room.name, rooms, room.is_public(path)) | {room.name}
    space = "lake" if room.name == "core" else f"lake::{room.name}"
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if include := re.match(r'\s*#\s*include\s*[<"]([^">]*)', line):
            parts = pathlib.PurePosixPath(include.group(1)).parts
            if ".." in parts:
                yield f"{path}:{number}: {include.group(1)} leaves the folder; include lake/ROOM/HEADER of a room"
            elif parts[0] == "lake" and parts[1] not in allowed:
                way = "public link lines" if parts[1] in reachable(room.name, rooms) else "link lines"
                yield f"{path}:{number}: {room.name} may not use {parts[1]} here: its {way} do not reach it"
        elif (opened := re.match(r"namespace (lake\b[\w:]*)", line)) and not f"{opened.group(1)}::".startswith(f"{space}::"):
            yield f"{path}:{number}: {room.name} has its names in {space}, not in {opened.group(1)}"


def check_sources(libs, rooms):
    by_folder = {room.folder: room for room in rooms.values()}
    for path in sorted(libs.rglob("*")):
        if path.suffix in SOURCES:
            room = owner(path, by_folder)
            yield from check_source(path, room, rooms) if room else [f"{path}: lies in no room"]


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent)
    found = find_rooms(root / "libs")
    problems = list(check_rooms(found))
    if not problems:
        rooms = {room.name: room for room in found}
        problems = [p for room in found for p in check_links(room, rooms)] + list(check_sources(root / "libs", rooms))
    for problem in problems:
        print(problem)
    print(f"layers: {len(found)} rooms, {len(problems)} problems")
    return 1 if problems or not found else 0


if __name__ == "__main__":
    sys.exit(main())
