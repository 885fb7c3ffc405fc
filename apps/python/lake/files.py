"""A folder of results, and the files in it that are no tables."""
from __future__ import annotations

import functools
import json
import os
import pathlib
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Union

from .tables import Table, frame, read_table

if TYPE_CHECKING:
    import pandas

Path = Union[str, "os.PathLike[str]"]


def read_yaml(path: Path) -> Any:
    """A YAML file of lake's: design.yaml, study.yaml, problem.yaml, or a camera.yaml, whose matrices become lists of rows. Needs PyYAML."""
    import yaml

    class Loader(yaml.SafeLoader):
        pass

    def matrix(loader: Any, node: Any) -> List[List[float]]:
        parts = loader.construct_mapping(node, deep=True)
        columns = parts["cols"]
        return [parts["data"][row * columns:(row + 1) * columns] for row in range(parts["rows"])]

    Loader.add_constructor("tag:yaml.org,2002:opencv-matrix", matrix)
    text = pathlib.Path(path).read_text(encoding="utf-8")
    # OpenCV begins its files with "%YAML:1.0", which YAML does not know.
    if text.startswith("%YAML:"):
        text = text.partition("\n")[2]
    return yaml.load(text, Loader)


class Folder:
    """What a program wrote: folder["kinematics"] is kinematics.csv as a data frame, folder.summary its summary.json."""

    def __init__(self, path: Path):
        self.path = pathlib.Path(path)
        if not self.path.is_dir():
            raise FileNotFoundError(f"{self.path}: no folder")

    def __repr__(self) -> str:
        return f"<lake.Folder {self.path}: {', '.join(self.tables) or 'no tables'}>"

    def __getitem__(self, table: str) -> "pandas.DataFrame":
        return frame(self._file(table, ".csv"))

    def __iter__(self) -> Iterator[str]:
        return iter(self.tables)

    def __contains__(self, table: object) -> bool:
        return table in self.tables

    def __truediv__(self, name: str) -> "Folder":
        """A folder in it, such as the step `human` of a study."""
        return Folder(self.path / name)

    def _file(self, name: str, ending: str) -> pathlib.Path:
        path = self.path / (name if name.endswith(ending) else name + ending)
        if not path.is_file():
            raise KeyError(f"{path}: there is no such file; there are {', '.join(self.tables) or 'no tables'}")
        return path

    @property
    def tables(self) -> List[str]:
        """Names of the tables, without .csv."""
        return sorted(path.stem for path in self.path.glob("*.csv"))

    @property
    def folders(self) -> List[str]:
        """Names of the folders in it that hold results, such as the steps of a study."""
        return sorted(path.parent.name for path in self.path.glob("*/summary.json"))

    @property
    def pictures(self) -> List[pathlib.Path]:
        return sorted(path for path in self.path.iterdir() if path.suffix in (".png", ".svg", ".gif"))

    def table(self, name: str) -> Table:
        """The same as folder[name], without pandas."""
        return read_table(self._file(name, ".csv"))

    def json(self, name: str) -> Any:
        """A JSON file: folder.json("comparison")."""
        return json.loads(self._file(name, ".json").read_text(encoding="utf-8"))

    def yaml(self, name: str) -> Any:
        """A YAML file: folder.yaml("design")."""
        return read_yaml(self._file(name, ".yaml"))

    @functools.cached_property
    def summary(self) -> Dict[str, Any]:
        return self.json("summary")

    @property
    def warnings(self) -> List[str]:
        return list(self.summary.get("warnings", []))

    @property
    def program(self) -> str:
        """Which program made it: "lake-track", …"""
        return str(self.summary.get("program", ""))


def read(path: Path) -> Folder:
    """The results that any program left in a folder."""
    return Folder(path)
