"""The tables that lake writes, with the unit and the meaning of each column."""
from __future__ import annotations

import csv
import functools
import os
import pathlib
import re
from typing import TYPE_CHECKING, Dict, List, NamedTuple, Optional, Union

if TYPE_CHECKING:
    import pandas

Path = Union[str, "os.PathLike[str]"]
Cell = Union[float, str, None]

_PLACES = {"{marker}": ".+", "{measure}": ".+", "{estimate}": ".+", "{link}": "l[1-6]"}


class Column(NamedTuple):
    """One line of columns.csv."""
    table: str
    column: str  # {marker} stands for a marker's name, {link} for l1 to l6
    unit: str  # empty where there is none, such as for names and counts
    meaning: str
    source: str = ""  # who defined it: a publication, or lake where the definition is its own


class Table(Dict[str, List[Cell]]):
    """Column → its cells: numbers, or text where a column has some that is none; None where a cell is empty."""

    name: str = ""

    @property
    def units(self) -> Dict[str, str]:
        return units(self.name, list(self))


@functools.lru_cache(maxsize=None)
def _catalogue() -> Dict[str, List[Column]]:
    tables: Dict[str, List[Column]] = {}
    with open(pathlib.Path(__file__).with_name("columns.csv"), encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            column = Column(row["table"], row["column"], row["unit"], row["meaning"], row["source"] or "")
            tables.setdefault(column.table, []).append(column)
    return tables


def columns_of(table: str = "") -> List[Column]:
    """What is known of the columns of a table, "kinematics" for kinematics.csv; without a name, of all tables."""
    return list(_catalogue().get(table, [])) if table else [column for all_of in _catalogue().values() for column in all_of]


def _matches(pattern: str, column: str) -> bool:
    expression = re.escape(pattern)
    for place, part in _PLACES.items():
        expression = expression.replace(re.escape(place), part)
    return re.fullmatch(expression, column) is not None


def describe(table: str, column: str) -> Optional[Column]:
    """The line of columns.csv that tells of this column, if there is one."""
    # The longest pattern that fits: knee_raw_x_mm is {marker}_raw_x_mm, not {marker}_x_mm of a marker knee_raw.
    fitting = [c for c in _catalogue().get(table, []) if _matches(c.column, column)]
    return max(fitting, key=lambda c: len(c.column), default=None)


# Of columns that columns.csv does not have: names end in their unit.
_ENDINGS = {"_deg_s": "deg/s", "_deg_per_mm": "deg/mm", "_mm_s2": "mm/s²", "_mm_s": "mm/s", "_mm": "mm", "_px": "px", "_deg": "deg", "_rad": "rad",
            "_nm_kg": "N m/kg", "_nm": "N m", "_n": "N", "_w": "W", "_j": "J", "_kg": "kg", "_s": "s", "_hz": "Hz", "percent": "%"}


def units(table: str, columns: List[str]) -> Dict[str, str]:
    """Unit of each column of a table: "kinematics", "events", …; empty for what has none."""
    found = {}
    for column in columns:
        known = describe(table, column)
        found[column] = known.unit if known else next((unit for end, unit in _ENDINGS.items() if column.endswith(end)), "")
    return found


def _cells(texts: List[str]) -> List[Cell]:
    try:
        return [float(text) if text else None for text in texts]
    except ValueError:
        return [text if text else None for text in texts]


def read_table(path: Path) -> Table:
    """A CSV file of lake's, without pandas."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    if not rows:
        raise ValueError(f"{os.fspath(path)}: empty; a table has a header line")
    for number, row in enumerate(rows, 1):
        if len(row) != len(rows[0]):
            raise ValueError(f"{os.fspath(path)}:{number}: {len(row)} cells, where the header has {len(rows[0])}")
    table = Table({name: _cells([row[i] for row in rows[1:]]) for i, name in enumerate(rows[0])})
    table.name = pathlib.Path(path).stem
    return table


def frame(path: Path) -> "pandas.DataFrame":
    """A CSV file of lake's as a data frame, every number the very double that was written; `attrs["units"]` has the unit of each column."""
    import pandas

    table = pandas.read_csv(path, float_precision="round_trip", keep_default_na=False, na_values=[""])
    table.attrs["units"] = units(pathlib.Path(path).stem, list(table.columns))
    return table
