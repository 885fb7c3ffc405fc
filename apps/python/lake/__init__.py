"""Run lake's programs and read what they write.

    import lake
    trial = lake.run("track", "human.mp4", camera="camera.yaml", out="human")
    trial["kinematics"].plot("time_s", "knee_deg")

Lengths are in mm, times in s, angles in degrees, as everywhere in lake; `units` tells of each column."""
from .files import Folder, read, read_yaml
from .programs import LakeError, LakeWarning, arguments, program, run
from .tables import Column, Table, columns_of, frame, read_table, units

__version__ = "0.2.0"
__all__ = ["Column", "Folder", "LakeError", "LakeWarning", "Table", "arguments", "columns_of", "frame", "program", "read",
           "read_table", "read_yaml", "run", "units"]
