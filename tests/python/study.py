"""The notebooks, run once for all tests of a process, and the folders of results that they leave."""
import functools
import os
import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SAMPLE = ROOT / "data/sts-study"
os.environ["PYTHONPATH"] = str(ROOT / "apps/python")
os.environ["PYDEVD_DISABLE_FILE_VALIDATION"] = "1"  # the kernel's debugger, which nobody uses here, would warn of itself
sys.path.insert(0, os.environ["PYTHONPATH"])

import lake  # noqa: E402

_kept = tempfile.TemporaryDirectory()


@functools.lru_cache(maxsize=None)
def notebooks():
    """Name → the notebook after it ran from top to bottom; skips the test where there is nothing that could run it."""
    try:
        import matplotlib  # noqa: F401
        import nbclient
        import nbformat
        import pandas  # noqa: F401
    except ImportError as missing:
        raise unittest.SkipTest(f"{missing.name} is not installed (python3-nbclient, python3-ipykernel, python3-pandas, python3-matplotlib)")
    os.environ.update(LAKE_EXAMPLES=str(ROOT), LAKE_OUT=_kept.name)
    ran = {}
    for name in ("analysis", "design"):
        ran[name] = nbformat.read(ROOT / f"apps/python/notebooks/{name}.ipynb", as_version=4)
        nbformat.validate(ran[name])
        assert not any(cell.get("outputs") for cell in ran[name].cells), f"{name}.ipynb is kept without its output"
        nbclient.NotebookClient(ran[name], timeout=300, kernel_name="python3", resources={"metadata": {"path": _kept.name}}).execute()
    return ran


@functools.lru_cache(maxsize=None)
def results():
    """Name → lake.Folder of each step that the notebooks ran."""
    notebooks()
    folder = lake.read(_kept.name)
    return {name: folder / name for name in folder.folders}
