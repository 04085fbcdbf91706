"""Kernels that come with the package: where they are taken, and where others are compiled."""

import numpy as np
import pytest

from robust_ik.kernels.compiler.compiling import filled, kernel
from robust_ik.kernels.loader import announcing, kernel_store, shipped, target
from robust_ik.kernels.loader.kernel import Kernel

SYSTEM, NAME, FEATURES = target.host()


@kernel(filled(1))
def negate(x):
    for i in range(len(x)):
        x[i] = -x[i]


def negating():
    """Whether a new kernel was there; that it works is checked."""
    missed, x = len(announcing.MISSED), np.ones(3)
    Kernel(__name__, "negate")(x)
    np.testing.assert_array_equal(x, -1.0)
    return len(announcing.MISSED) == missed


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where kernels are shipped, with the one of this file; they lie nowhere else, and nothing can be written."""
    for name in (*target.SETTINGS, "NUMBA_CPU_FEATURES", "NUMBA_CPU_NAME"):
        monkeypatch.delenv(name, raising=False)
    made = tmp_path / "shipped"
    monkeypatch.setattr(announcing, "MISSED", [])
    monkeypatch.setattr(kernel_store, "_told", [])
    monkeypatch.setattr(kernel_store, "places", lambda: iter([made]))
    assert [negating(), negating()] == [False, True]
    described = target.target().replace(NAME, "x86-64-v3")  # as if it had been compiled for that
    (file,) = made.iterdir()
    file.rename(made / kernel_store._file("test_shipped.negate", negate.sources(), described))
    (made / "target").write_text(shipped.described(described))
    monkeypatch.setattr(kernel_store, "places", lambda: iter([tmp_path / "nowhere"]))
    monkeypatch.setattr(kernel_store, "_put", lambda *_: None)
    monkeypatch.setattr(kernel_store, "SHIPPED", made)
    monkeypatch.setattr(shipped, "FILE", made / "target")
    shipped.shipped.cache_clear()
    yield made
    shipped.shipped.cache_clear()


def test_what_is_shipped_is_taken(folder):
    assert negating()


@pytest.mark.parametrize("name", ["NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "NUMBA_BOUNDSCHECK"])
def test_what_is_shipped_is_left_alone_where_something_else_is_asked_for(folder, monkeypatch, name):
    monkeypatch.setenv(name, {"NUMBA_CPU_NAME": NAME, "NUMBA_CPU_FEATURES": FEATURES}.get(name, "0"))
    assert shipped.shipped() is None


@pytest.mark.parametrize(
    "change",
    [
        lambda lines: [],
        lambda lines: lines[:-1],
        lambda lines: [*lines, "more"],
        lambda lines: [*lines[:2], "cpython-27", lines[3]],
        lambda lines: [*lines[:3], "sparc-sun-solaris"],
        lambda lines: [lines[0], "x86-64-v9", *lines[2:]],
    ],
)
def test_what_is_shipped_for_another_python_or_system_is_not_taken(folder, change):
    lines = shipped.FILE.read_text().split("\n")
    shipped.FILE.write_text("\n".join(change(lines)))
    assert not negating()


def test_what_is_shipped_is_not_taken_by_a_processor_that_lacks_some_of_it(folder, monkeypatch):
    lines = shipped.FILE.read_text().split("\n")
    shipped.FILE.write_text("\n".join([lines[0], "x86-64-v3", *lines[2:]]))
    all_of_it = ",".join(f"+{each}" for each in sorted(shipped.LEVELS["x86-64-v3"]))
    for features, taken in ((all_of_it, True), (all_of_it.replace("+fma", "-fma"), False), ("", False)):
        monkeypatch.setattr(shipped, "host", lambda features=features: (SYSTEM, NAME, features))
        shipped.shipped.cache_clear()
        assert (shipped.shipped() is not None) == taken


def test_a_shipped_file_that_another_may_have_written_is_not_run(folder, monkeypatch):
    monkeypatch.setattr(kernel_store, "_is_trusted", lambda place: place != folder)
    assert not negating()


def test_no_level_asks_for_a_feature_that_llvm_does_not_know():
    known = {each[1:] for each in FEATURES.split(",")}
    if SYSTEM.startswith("x86_64"):
        assert shipped.LEVELS[shipped.level()] <= known
    assert not shipped.LEVELS["generic"]
