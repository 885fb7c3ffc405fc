"""Running the programs: keyword arguments in, a folder of results out."""
from __future__ import annotations

import json
import os
import pathlib
import shutil
import subprocess
import warnings
from typing import Any, List, Mapping, Optional, Union

from .files import Folder

Operand = Union[str, "os.PathLike[str]"]

# These write no folder of results; what they say is all they do.
_WITHOUT_FOLDER = {"convert": [], "info": ["--json"]}


class LakeError(RuntimeError):
    """A program failed: its one line of complaint, and its exit code.

    `exit_code` is 1 if the input or the run failed, 2 for wrong usage, 3 if a solver ended without a usable solution; then `folder`
    may hold its best point, marked as such."""

    def __init__(self, message: str, exit_code: int, folder: Optional[pathlib.Path] = None):
        super().__init__(message)
        self.exit_code = exit_code
        self.folder = folder


class LakeWarning(UserWarning):
    """What a program found odd about its input or its results."""


def program() -> str:
    """The front door `lake`: of the environment variable LAKE if it is set, else of PATH."""
    found = shutil.which(os.environ.get("LAKE", "lake"))
    if found is None:
        raise FileNotFoundError(f"the program {os.environ.get('LAKE', 'lake')!r} is not found: put its folder into PATH, or its path into LAKE")
    return found


def _text(value: Any) -> str:
    if isinstance(value, (tuple, list)):
        return ",".join(_text(part) for part in value)
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)


def arguments(**options: Any) -> List[str]:
    """Keyword arguments as a command line has them.

    max_misalignment=2 is --max-misalignment=2, and overlay=False is --no-overlay; True is the option alone, None leaves it out. A tuple is joined
    by commas (crop=(0, 0, 640, 480)), a list gives the option several times, and a mapping gives it as NAME=VALUE for each of its items
    (seed={"exo_knee": (740, 415)}). A name that Python keeps for itself takes an underscore at its end: return_=True."""
    words: List[str] = []
    for name, value in options.items():
        option = "--" + name.rstrip("_").replace("_", "-")
        if value is None:
            continue
        if isinstance(value, bool):
            words.append(option if value else option.replace("--", "--no-", 1))
        elif isinstance(value, Mapping):
            words += [f"{option}={key}={_text(part)}" for key, part in value.items()]
        else:
            words += [f"{option}={_text(part)}" for part in (value if isinstance(value, list) else [value])]
    return words


def _complaint(stderr: str) -> str:
    lines = [line for line in stderr.splitlines() if line.strip()]
    return lines[-1] if lines else "ended without a word"


def run(step: str, *operands: Operand, out: Optional[Operand] = None, **options: Any) -> Any:
    """Runs `lake STEP OPERANDS… --option=value …`, waits for it, and returns its results.

    A step that writes a folder returns a Folder: `out`, or ./lake-out/NAME as on the command line. Warnings of the program become a
    LakeWarning each. info returns its findings as a dict, convert the path that it wrote. `lake.run("check", video)` returns a
    Folder also for a recording that is not fit: its summary["fit"] says so. Raises LakeError for every other failure, with the
    program's own message."""
    command = [program(), step, *(os.fspath(operand) for operand in operands), *arguments(**options)]
    command += _WITHOUT_FOLDER.get(step, ["--json", "--quiet"])
    if out is not None:
        command.append(f"--out={os.fspath(out)}")
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8", errors="replace", check=False)
    is_verdict = step == "check" and done.returncode == 1 and done.stdout.startswith("{")
    if done.returncode != 0 and not is_verdict:
        raise LakeError(_complaint(done.stderr), done.returncode, pathlib.Path(out) if out is not None else None)
    if step == "convert":
        return pathlib.Path(operands[-1])
    said = json.loads(done.stdout)
    if step == "info":
        return said
    for warning in said.get("warnings", []):
        warnings.warn(f"lake {step}: {warning}", LakeWarning, stacklevel=2)
    return Folder(out if out is not None else said["options"]["out"])
