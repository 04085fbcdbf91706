"""The systems beside ours: an interpreter for each, and a process that is asked for rounds."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from rich.console import Console

from benchmarks.peers.timing import Sample

SCRIPTS = Path(__file__).parent / "peers"
CACHE = Path(__file__).parents[1] / "out" / "peers"
SYSTEM = {"pykdl": ("/usr/bin/python3", "import PyKDL, numpy", "Debian's packages python3-pykdl and python3-numpy")}
"""Peers that no package index has: interpreter, what it must be able to do, and what that takes."""
PATIENCE = 1200  # seconds for one answer
progress = Console(stderr=True)


class UnavailableError(Exception):
    """A contender cannot be measured here; the message is the reason that a table gives."""


def call(command: list[str]) -> str:
    """Standard output of a command, which gets one thread of BLAS.

    Raises:
        UnavailableError: It fails.
    """
    done = subprocess.run(command, env=one_thread(), capture_output=True, text=True, check=False)
    if done.returncode:
        raise UnavailableError(last_line(done.stderr) or f"exit code {done.returncode}")
    return done.stdout


def one_thread() -> dict[str, str]:
    """The environment of a process that is to keep to one core."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    return {**os.environ, **dict.fromkeys(names, "1")}


def last_line(text: str) -> str:
    """What a failed command says last, short enough for a table."""
    lines = text.strip().splitlines()
    return lines[-1][:120].replace("|", "/") if lines else ""


def interpreter(peer: str) -> str:
    """The interpreter of a peer; its environment is made first where it is not there yet.

    Raises:
        UnavailableError: It cannot be installed.
    """
    if peer == "robust_ik":
        return sys.executable
    if peer in SYSTEM:
        python, probe, needed = SYSTEM[peer]
        try:
            call([python, "-c", probe])
        except (UnavailableError, OSError):
            raise UnavailableError(f"needs {needed}") from None
        return python
    home, requirements = CACHE / peer, SCRIPTS / f"requirements-{peer}.txt"
    python, done = home / "bin" / "python", home / "installed.txt"
    wanted = requirements.read_text(encoding="utf-8")
    if not done.is_file() or done.read_text(encoding="utf-8") != wanted:
        progress.print(f"installing {peer} …")
        call([sys.executable, "-m", "venv", "--clear", str(home)])
        try:
            call([str(python), "-m", "pip", "install", "--quiet", "--requirement", str(requirements)])
        except UnavailableError as error:
            raise UnavailableError(f"cannot be installed: {error}") from None
        done.write_text(wanted, encoding="utf-8")
    return str(python)


@dataclass
class Peer:
    """A running script of benchmarks/peers, as a context manager.

    Attributes:
        name: Which peer: its environment and the first part of the script's name.
        kind: Which work: the second part.
        work: The file of it.
        options: Of the script.
        hello: What it said first: peer, version, options.
    """

    name: str
    kind: str
    work: Path
    options: tuple[str, ...] = ()
    hello: dict[str, Any] = field(default_factory=dict)

    def __enter__(self) -> Self:
        script = SCRIPTS / f"{self.name}_{self.kind}.py"
        command = [interpreter(self.name), str(script), str(self.work), *self.options]
        self._errors = tempfile.TemporaryFile("w+")
        self._process = subprocess.Popen(
            command, env=one_thread(), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors, text=True
        )
        try:
            self.hello = self._answer()
        except UnavailableError:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.kill()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout, self._errors):
            if stream and not stream.closed:
                try:
                    stream.close()
                except BrokenPipeError:  # it died before it read the last line
                    continue

    def round(self) -> Sample:
        """All its work, once.

        Raises:
            UnavailableError: It failed.
        """
        assert self._process.stdin
        try:
            print("round", file=self._process.stdin, flush=True)
        except BrokenPipeError:
            raise UnavailableError(f"failed: {self._reason()}") from None
        line = self._answer()
        return Sample(line["cpu_us"], np.array(line["us"]), np.array(line["answers"]))

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout
        timer = threading.Timer(PATIENCE, self._process.kill)
        timer.start()
        line = self._process.stdout.readline()
        timer.cancel()
        if not line:
            raise UnavailableError(f"failed: {self._reason()}")
        return json.loads(line)

    def _reason(self) -> str:
        code = self._process.wait()
        self._errors.seek(0)
        return last_line(self._errors.read()) or f"exit code {code}"
