"""Expands xacro files to URDF text by xacrodoc, if installed; ROS is not needed."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from robust_ik.errors import InputError, LoadError, UrdfError, cut

SUFFIX = ".xacro"
SECONDS = 60
"""Seconds after which an expansion is stopped."""
MEMORY = 1_000_000_000
"""Most bytes of address space of the process that expands. Chosen: forty times the 25 MB of xacrodoc by itself."""
MOST_CHARACTERS = 50_000_000
"""Most characters of the expanded URDF: as many as a URDF file may have bytes, `urdf_reader.MAX_BYTES`."""
_START = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from robust_ik.description.urdf.xacro_process import main
main()
"""


def checked_arguments(arguments: Mapping[str, object] | None) -> dict[str, str]:
    """Arguments of a xacro file as text; booleans are written as xacro reads them.

    Raises:
        InputError: They are no mapping, or a name is not valid.
    """
    if arguments is None:
        return {}
    if not isinstance(arguments, Mapping):
        raise InputError(f"xacro_args must map names to values, got {cut(repr(arguments), 200)}")
    for name in arguments:
        if not isinstance(name, str) or not re.fullmatch(r"\w[\w.-]*", name):
            raise InputError(f"xacro_args must map names to values, got the name {cut(repr(name), 200)}")
    return {name: str(value).lower() if isinstance(value, bool) else str(value) for name, value in arguments.items()}


def expand(path: Path, arguments: Mapping[str, str], package_dirs: Sequence[str | Path] = ()) -> str:
    """The URDF text that a xacro file writes.

    A process of its own does it, in a minute at the most; it may read the robot's folders and packages only.

    Args:
        path: The file, absolute.
        arguments: Values of its <xacro:arg>.
        package_dirs: Folders of packages for `$(find …)`.

    Raises:
        LoadError: xacrodoc is not installed.
        UrdfError: The file cannot be expanded.
    """
    if importlib.util.find_spec("xacrodoc") is None:
        raise LoadError(
            f"{path} is xacro, which xacrodoc expands: pip install 'robust-ik[xacro]', or run "
            f"'xacro {path.name} > robot.urdf' where ROS is installed"
        )
    folders = [str(Path(each).expanduser().absolute()) for each in package_dirs]
    job = {"path": str(path), "arguments": dict(arguments), "package_dirs": folders, "memory": MEMORY}
    command = [sys.executable, "-I", "-c", _START, json.dumps([str(Path(each).absolute()) for each in sys.path])]
    try:
        run = subprocess.run(command, input=json.dumps(job).encode(), capture_output=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        raise UrdfError(f"{path}: its xacro was given up after {SECONDS} seconds") from None
    if run.returncode != 0:
        raise UrdfError(f"{path}: its xacro ended the process that expands it (status {run.returncode})")
    answer = json.loads(run.stdout)
    if "urdf" not in answer:
        raise UrdfError(f"{path}: its xacro cannot be expanded: {_sentence(answer)}")
    text = str(answer["urdf"])
    if "<link" not in text:
        raise UrdfError(f"{path}: its xacro writes no link: name the file that uses its macros instead")
    if len(text) > MOST_CHARACTERS:
        raise UrdfError(f"{path}: its xacro writes {len(text)} characters; over {MOST_CHARACTERS} are refused")
    return text


def _sentence(answer: Mapping[str, str]) -> str:
    """The error in one line, with advice."""
    error = " ".join(answer["error"].split())
    if "Undefined substitution argument" in error:
        error += "; give it by xacro_args= (--xacro-arg NAME:=VALUE)"
    return cut(error, 600)
