"""DH tables: from TOML files, and to URDF."""

from robust_ik.description.dh.dh_table import DHTable, screw
from robust_ik.description.dh.dh_toml import read_dh
from robust_ik.description.dh.dh_urdf import dh_to_urdf

__all__ = [
    "DHTable",
    "dh_to_urdf",
    "read_dh",
    "screw",
]
