"""How kernels are compiled and kept: what a person never sees unless it fails."""

import ctypes
import gc
import logging
import math
import os
import shutil
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from pathlib import Path

import numba
import numpy as np
import pytest

import robust_ik as rik
from robust_ik import kernels
from robust_ik.cli.warmup import warmup as warmup_command
from robust_ik.control.compiled_step import kernel_warmup
from robust_ik.kernels.compiler import gain_callbacks, object_files
from robust_ik.kernels.compiler.array_handles import address_of
from robust_ik.kernels.compiler.compiling import FLOAT, HANDLE, WHOLE, Definition, filled, given, kernel
from robust_ik.kernels.loader import announcing, kernel_store, target
from robust_ik.kernels.loader import kernel as kernel_module
from robust_ik.kernels.loader.kernel import Kernel, every_kernel

PANDA = rik.load("panda")


def double(x):
    for i in range(len(x)):
        x[i] *= 2


def half(x):
    return x / 2


doubled, halved = kernel(filled(1))(double), kernel(FLOAT)(half)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The only place where kernels may lie."""
    monkeypatch.setattr(kernel_store, "places", lambda: iter([tmp_path / "cache"]))
    monkeypatch.setattr(kernel_store, "_told", [])
    monkeypatch.setattr(announcing, "MISSED", [])
    return tmp_path / "cache"


def doubling():
    """Whether a new kernel was read from disk; that it works is checked."""
    missed, x = len(announcing.MISSED), np.ones(3)
    Kernel(__name__, "doubled")(x)
    np.testing.assert_array_equal(x, 2.0)
    return len(announcing.MISSED) == missed


# ---------------------------------------------------------------------------------------------------- kept
def test_what_was_compiled_is_read_the_next_time(folder):
    assert [doubling(), doubling()] == [False, True]
    assert [file.suffix for file in folder.iterdir()] == [".kernel"]


@pytest.mark.parametrize(
    "damage",
    [
        lambda _: b"",
        lambda whole: whole[:100],
        lambda whole: whole[:-1] + b"?",
        lambda _: kernel_store._digest(b"no") + b"no",
    ],
    ids=["empty", "cut off", "one byte changed", "whole, and no kernel"],
)
def test_a_damaged_file_is_compiled_again_and_replaced(folder, damage):
    doubling()
    (file,) = folder.iterdir()
    file.write_bytes(damage(file.read_bytes()))
    assert [doubling(), doubling()] == [False, True]


def test_with_no_folder_to_write_to_all_works_and_is_said_once(tmp_path, folder, monkeypatch, caplog):
    (tmp_path / "file").touch()
    monkeypatch.setattr(kernel_store, "places", lambda: iter([tmp_path / "file" / "below"]))
    with caplog.at_level(logging.WARNING, "robust_ik"):
        assert [doubling(), doubling()] == [False, False]
    (record,) = caplog.records
    assert "NUMBA_CACHE_DIR" in record.getMessage()


def test_the_next_folder_is_taken_where_the_first_cannot_be_written(tmp_path, folder, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setattr(kernel_store, "places", lambda: iter([tmp_path / "file" / "below", folder]))
    assert [doubling(), doubling()] == [False, True]


def test_a_folder_that_may_only_be_read_is_read(folder, monkeypatch):
    doubling()
    monkeypatch.setattr(kernel_store, "_put", lambda *_: pytest.fail("nothing is written"))
    assert doubling()


def opened(path, mode):
    path.chmod(mode)


def sold(path, _):
    os.chown(path, 12345, -1)


unix = pytest.mark.skipif(os.name == "nt", reason="Windows keeps rights elsewhere")
as_root = pytest.mark.skipif(os.name == "nt" or os.geteuid() != 0, reason="only root can give files away")


@unix
@pytest.mark.parametrize("mode", [0o777, 0o757, 0o1777])
@pytest.mark.parametrize("which", ["the folder", "the one above"])
def test_a_folder_that_others_can_write_to_is_not_used_and_that_is_said_once(folder, caplog, monkeypatch, which, mode):
    if which == "the one above" and mode & 0o1000:
        pytest.skip("in a sticky folder nobody can replace another's")
    above = folder.parent / "above"
    monkeypatch.setattr(kernel_store, "places", lambda: iter([above / "below", folder]))
    monkeypatch.setattr(kernel_store, "_refused", set())
    doubling()
    opened(above / "below" if which == "the folder" else above, mode)
    with caplog.at_level(logging.WARNING, "robust_ik"):
        assert [doubling(), doubling()] == [False, True]  # compiled, and kept in the next place
    assert len(list(folder.iterdir())) == 1
    (record,) = caplog.records
    assert f"{above / 'below'} are not used: everybody can write to " in record.getMessage()


@unix
@pytest.mark.parametrize("change", [opened, pytest.param(sold, marks=as_root)])
def test_a_file_that_another_may_have_written_is_not_run_but_replaced(folder, caplog, change):
    doubling()
    (file,) = folder.iterdir()
    change(file, 0o666)
    with caplog.at_level(logging.WARNING, "robust_ik"):
        assert [doubling(), doubling()] == [False, True]
    assert "is not used" in caplog.records[0].getMessage()
    assert file.stat().st_mode & 0o022 == 0


@as_root
def test_a_folder_of_another_user_is_not_used(folder, monkeypatch, caplog):
    monkeypatch.setattr(kernel_store, "_refused", set())
    folder.mkdir()
    sold(folder, None)
    assert [doubling(), doubling()] == [False, False]
    assert "belongs to another user (uid 12345)" in caplog.text


@unix
def test_what_is_kept_is_closed_to_others_whatever_the_umask_is(folder):
    before = os.umask(0)
    try:
        assert [doubling(), doubling()] == [False, True]
    finally:
        os.umask(before)
    assert [path.stat().st_mode & 0o022 for path in (folder, *folder.iterdir())] == [0, 0]


@unix
def test_beside_the_sources_a_folder_may_be_as_open_as_they_are(tmp_path, monkeypatch):
    monkeypatch.setattr(kernel_store, "FOLDER", tmp_path)
    monkeypatch.setattr(kernel_store, "places", lambda: iter([tmp_path / "__pycache__"]))
    monkeypatch.setattr(kernel_store, "_refused", set())
    tmp_path.chmod(0o777)
    (tmp_path / "__pycache__").mkdir()
    (tmp_path / "__pycache__").chmod(0o777)
    assert list(kernel_store._trusted_places()) == [tmp_path / "__pycache__"]
    tmp_path.chmod(0o755)
    assert list(kernel_store._trusted_places()) == []


@pytest.mark.parametrize("broken", [OSError(28, "No space left on device"), TypeError("cannot pickle"), MemoryError()])
def test_an_error_in_writing_is_none_of_the_caller_s(folder, monkeypatch, broken):
    def put(*_):
        raise broken

    monkeypatch.setattr(kernel_store, "_put", put)
    assert [doubling(), doubling()] == [False, False]


def test_half_a_file_is_never_left(folder, monkeypatch):
    def full(path, content):
        path.touch()
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(kernel_store, "_put", full)
    assert not doubling()
    assert list(folder.iterdir()) == []


def test_functions_that_cannot_be_told_apart_on_disk_are_not_kept(folder, monkeypatch):
    factor, space = 3.0, {}
    exec("def from_no_file(x): x[0] = 3.0", space)

    def closure(x):
        x[0] = factor

    for function in (closure, space["from_no_file"]):
        x = np.ones(1)
        monkeypatch.setitem(globals(), "made", kernel(filled(1))(function))
        Kernel(__name__, "made")(x)
        assert x[0] == 3
    assert not folder.exists()


FACTOR = 3.0


def scaled(x):
    return FACTOR * half(x)


def test_the_functions_and_numbers_that_a_function_names_are_part_of_it(monkeypatch):
    names = {kernel_store.sources_of(scaled, "")}
    monkeypatch.setitem(globals(), "FACTOR", 4.0)
    names |= {kernel_store.sources_of(scaled, "")}
    monkeypatch.setitem(globals(), "half", kernel_store._digest)
    names |= {kernel_store.sources_of(scaled, "")}
    assert len(names - {None}) == 3


def test_old_files_of_a_kernel_go(tmp_path):
    for number in range(12):
        path = tmp_path / f"a.b-{number}.kernel"
        kernel_store._write(path, b"")
        os.utime(path, (number, number))
    kernel_store._write(tmp_path / "a.c-0.kernel", b"")
    kernel_store._prune(path)
    assert {file.name for file in tmp_path.iterdir()} == {"a.c-0.kernel", *(f"a.b-{n}.kernel" for n in range(4, 12))}


def test_the_sources_of_functions_tell_them_and_their_types_apart():
    given = Definition(double, (FLOAT,)), Definition(double, (FLOAT, FLOAT)), Definition(half, (FLOAT,))
    assert len({each.sources() for each in given}) == 3


@pytest.mark.parametrize("change", ["processor", "features", "Python", "setting", "Numba's file", "Numba"])
def test_whatever_changes_machine_code_changes_the_names_of_files(monkeypatch, tmp_path, change):
    monkeypatch.chdir(tmp_path)
    for name in (*target.SETTINGS, "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"):
        monkeypatch.delenv(name, raising=False)
    before = target.target()
    if change == "Python":
        monkeypatch.setattr(sys, "abiflags", "t", raising=False)
    elif change == "Numba":
        monkeypatch.setattr(target, "_compiler", lambda: ("", "another"))
    elif change == "Numba's file":
        (tmp_path / target.FILE).write_text("opt: 1")
    else:
        name = {"processor": "NUMBA_CPU_NAME", "features": "NUMBA_CPU_FEATURES", "setting": "NUMBA_BOUNDSCHECK"}
        monkeypatch.setenv(name[change], "1")
    assert target.target() != before


@pytest.mark.parametrize("features", [None, "", "+avx"])
@pytest.mark.parametrize("name", [None, "generic", "x86-64-v3"])
def test_the_processor_is_the_one_that_numba_compiles_for(name, features):
    script = (
        "from robust_ik.kernels.loader.target import processor\n"
        "found = processor()\n"
        "from numba.core.registry import cpu_target\n"
        "print(found == cpu_target.target_context.codegen().magic_tuple())"
    )
    names = {"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": features}
    environment = {key: value for key, value in os.environ.items() if key not in names}
    environment |= {key: value for key, value in names.items() if value is not None}
    found = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "True"


def test_the_version_of_numba_is_read_without_importing_it():
    assert numba.__version__ in target._compiler()[1]


def test_kernels_lie_in_the_folder_that_is_named_or_beside_the_sources_or_with_the_user(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    named, beside, user = kernel_store.places()
    assert named == tmp_path / "robust_ik"
    assert beside == Path(kernels.__file__).parent / "__pycache__"
    assert user.name == "robust_ik"


@pytest.mark.skipif(sys.platform != "linux", reason="others do not ask for HOME")
def test_without_a_home_nothing_is_written_where_the_program_happens_to_run(monkeypatch):
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)  # what it does for a user who has none
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    assert list(kernel_store.places()) == [Path(kernels.__file__).parent / "__pycache__"]


# ---------------------------------------------------------------------------------------------------- processes
PROGRAM = """
import sys
import numpy as np
from robust_ik.kernels.loader.kernel import Kernel
x = np.ones(1)
Kernel("robust_ik.kernels.outer", "double")(x)
print(x[0], int("numba" not in sys.modules))
"""


@pytest.fixture
def package(tmp_path):
    """A copy of what compiles, with a kernel that is made of a piece from another file."""
    below = tmp_path / "here" / "robust_ik" / "kernels"
    (below / "deep").mkdir(parents=True)
    for empty in (below.parent, below, below / "deep"):
        (empty / "__init__.py").touch()
    for room in ("compiler", "loader"):
        shutil.copytree(Path(kernels.__file__).parent / room, below / room)
    (below / "deep" / "inner.py").write_text(
        "from robust_ik.kernels.compiler.compiling import inlined\n@inlined\ndef twice(x):\n    return 2 * x\n"
    )
    (below / "deep" / "layout.py").write_text("MORE = 0.0\n")  # what a kernel reads of a module, it does not name
    (below / "outer.py").write_text(
        "from robust_ik.kernels.compiler.compiling import filled, kernel\n"
        "from robust_ik.kernels.deep import layout\nfrom robust_ik.kernels.deep.inner import twice\n"
        "@kernel(filled(1))\ndef double(x):\n    x[0] = twice(x[0]) + layout.MORE\n"
    )
    return tmp_path / "here"


def start(folder):
    environment = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
    environment |= {"PYTHONPATH": str(folder), "PYTHONSAFEPATH": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.Popen([sys.executable, "-c", PROGRAM], env=environment, stdout=subprocess.PIPE, text=True)


def answer(process):
    value, hits = process.communicate()[0].split()
    return float(value), bool(int(hits))


@pytest.mark.slow
def test_a_kernel_is_as_new_as_all_its_pieces_wherever_they_lie(package, tmp_path):
    for value, _ in map(answer, [start(package), start(package)]):  # compiled by two at once
        assert value == 2
    assert answer(start(package)) == (2, True)
    package = package.rename(tmp_path / "there")
    assert answer(start(package)) == (2, True)
    piece = package / "robust_ik" / "kernels" / "deep" / "inner.py"
    piece.write_text(piece.read_text().replace("2", "3"))
    assert answer(start(package)) == (3, False)
    assert answer(start(package)) == (3, True)
    layout = package / "robust_ik" / "kernels" / "deep" / "layout.py"
    before = answer(start(package))[0]
    layout.write_text("MORE = 5.0\n")
    assert answer(start(package)) == (before + 5, False)


# ---------------------------------------------------------------------------------------------------- called
def locked(array):
    array.flags.writeable = False
    return array


@pytest.mark.parametrize(
    "wrong",
    [
        np.ones(2, dtype=int),
        np.ones(2, dtype="f4"),
        np.ones(2, dtype=">f8"),
        np.ones((2, 2)),
        np.array(1.0),
        np.ones(4)[::2],
        np.frombuffer(bytearray(17), dtype=float, offset=1),
        locked(np.ones(2)),
        np.ma.masked_array(np.ones(2)),
        [1.0],
        None,
    ],
    ids=str,
)
def test_other_arrays_are_refused(folder, wrong):
    with pytest.raises(
        TypeError, match="doubled? takes as argument 1 a C-contiguous array of doubles with 1 axis, whic"
    ):
        Kernel(__name__, "doubled")(wrong)


@kernel(given(2), WHOLE, FLOAT, filled(1))
def weighed(x, factor, share, sums):
    for row in range(len(x)):
        sums[row] = 0.0
        for entry in x[row]:
            sums[row] += factor * share * entry
    return x.shape[1]


@kernel(HANDLE, WHOLE)
def nothing(handle, whole):
    address_of(handle)


@kernel(FLOAT)
def positive(x):
    return x > 0


def test_arguments_and_results_are_those_of_python(folder):
    x, sums = locked(np.arange(6.0).reshape(2, 3)), np.empty(2)
    assert Kernel(__name__, "weighed")(x, np.int64(2), 0.5, sums) == 3
    np.testing.assert_array_equal(sums, x.sum(axis=1))
    assert Kernel(__name__, "weighed")(np.empty((0, 3)), True, 1, np.empty(0)) == 3
    assert Kernel(__name__, "nothing")(object(), -(2**63)) is None
    assert Kernel(__name__, "halved")(3) == 1.5
    assert math.isnan(Kernel(__name__, "halved")(math.nan))
    assert [Kernel(__name__, "halved")(-2.0), Kernel(__name__, "positive")(-1.0)] == [-1.0, False]
    assert Kernel(__name__, "positive")(1.0) is True


@pytest.mark.parametrize(
    "wrong, error, text",
    [
        ((), TypeError, "takes 4 arguments"),
        ((np.ones((1, 1)), 1, 1.0, np.ones(1), 1), TypeError, "takes 4 arguments"),
        ((np.ones((1, 1)), 1.5, 1.0, np.ones(1)), TypeError, "'float' object cannot be interpreted as an integer"),
        ((np.ones((1, 1)), 2**63, 1.0, np.ones(1)), OverflowError, "too big"),
        ((np.ones((1, 1)), 1, "1", np.ones(1)), TypeError, "must be real number, not str"),
        ((np.ones((1, 1)), 1, 1.0, locked(np.ones(1))), TypeError, "argument 4 .* 1 axis, which it writes to"),
        ((np.ones(1), 1, 1.0, np.ones(1)), TypeError, "argument 1 .* with 2 axes$"),
    ],
)
def test_other_arguments_are_errors_that_say_why(folder, wrong, error, text):
    with pytest.raises(error, match=text):
        Kernel(__name__, "weighed")(*wrong)


def test_references_are_neither_kept_nor_lost(folder):
    made, x, sums, big = Kernel(__name__, "weighed"), np.ones((1, 1)), np.empty(1), 2**40 + 5
    counted = (x, sums, big, None, TypeError, np.ndarray)
    nothing_made = Kernel(__name__, "nothing")
    made(x, big, 1.0, sums)  # to compile refers to much that stays
    nothing_made(x, big)
    gc.collect()
    before = [sys.getrefcount(each) for each in counted]
    for _ in range(1000):
        made(x, big, 1.0, sums)
        nothing_made(x, big)
        with pytest.raises(TypeError):
            made(x, big, "no", sums)
    gc.collect()  # of the errors
    after = [sys.getrefcount(each) for each in counted]
    assert np.abs(np.subtract(after, before)).max() < 500


def test_kernels_let_other_threads_run_unless_they_take_handles():
    called = [each.made().content.split(b"\n")[0].decode().split() for each in (weighed, nothing)]
    assert [set(names) >= {"PyEval_SaveThread", "PyEval_RestoreThread"} for names in called] == [True, False]


@kernel(given(1), WHOLE)
def entry_of(x, index):
    return x[index]


@pytest.mark.slow
def test_an_error_in_compiled_code_is_one_of_python():
    script = (
        "import numpy as np\n"
        "from robust_ik.kernels.loader.kernel import Kernel\n"
        "try:\n    Kernel('tests.kernels.test_compiling', 'entry_of')(np.ones(3), 5)\n"
        "except RuntimeError as error:\n    print(error)\n"
    )
    environment = os.environ | {"NUMBA_BOUNDSCHECK": "1"}
    found = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    assert "entry_of failed: an index is out of bounds" in found.stdout


def test_threads_that_need_a_kernel_at_once_get_the_same(folder, monkeypatch):
    made, together = [], threading.Barrier(8)
    real = kernel_store.obtained
    monkeypatch.setattr(kernel_store, "obtained", lambda *given: made.append(real(*given)) or made[-1])
    kernel = Kernel(__name__, "doubled")

    def get(_):
        together.wait()
        return kernel.compiled

    with ThreadPoolExecutor(8) as pool:
        got = set(pool.map(get, range(8)))
    assert got == set(made)
    assert len(made) == 1


def formula(sigma, largest, smallest, product, after, parameters):
    if sigma < 0:
        raise ValueError
    return half(sigma) + parameters[1]


def test_a_formula_is_called_by_its_address_and_kept(folder, monkeypatch):
    parameters = (ctypes.c_double * 2)(0.0, 10.0)
    for _ in range(2):
        monkeypatch.setattr(gain_callbacks, "_addresses", {})
        address = gain_callbacks.address_of(formula)
        assert gain_callbacks.address_of(formula) == address
        called = ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * 5, ctypes.POINTER(ctypes.c_double))(address)
        assert called(3.0, 0.0, 0.0, 0.0, 0.0, parameters) == 11.5
        assert math.isnan(called(-3.0, 0.0, 0.0, 0.0, 0.0, parameters))
    assert announcing.MISSED == ["test_compiling.formula"]


# ---------------------------------------------------------------------------------------------------- warmup
def module_names():
    """All modules of kernels, from their files."""
    root = Path(kernels.__file__).parents[2]
    files = sorted(Path(kernels.__file__).parent.rglob("*.py"))
    return [".".join(file.relative_to(root).with_suffix("").parts) for file in files if file.stem != "__init__"]


def test_every_kernel_of_every_module_is_found():
    modules = [import_module(name) for name in module_names()]
    defined = {id(each) for module in modules for each in vars(module).values() if isinstance(each, Definition)}
    assert defined
    assert defined == {id(each.definition) for each in every_kernel()}
    assert {each.name for each in every_kernel()} == {each.definition.function.__name__ for each in every_kernel()}
    for room in {each.module.rpartition(".")[0] for each in every_kernel()}:
        named = {name: each for name, each in vars(import_module(room)).items() if isinstance(each, Kernel)}
        assert named == {each.name: each for each in every_kernel() if each.module.startswith(f"{room}.")}


def test_warmup_compiles_all_kernels_and_tells_how_far_it_is(folder, monkeypatch):
    few, told = [Kernel(__name__, "doubled"), Kernel(__name__, "halved")], []
    monkeypatch.setattr(kernel_module, "every_kernel", lambda: few)
    monkeypatch.setattr(kernel_warmup, "CLASSES", (rik.JParse, rik.SDLS))
    monkeypatch.setattr(gain_callbacks, "_addresses", {})
    assert rik.warmup(progress=lambda *step: told.append(step)) > 0
    assert told == [(0, 3), (1, 3), (2, 3), (3, 3)]
    assert len(list(folder.iterdir())) == 3  # of what SDLS does nothing is compiled


def test_what_takes_long_to_compile_says_so_and_only_when_it_is_not_on_disk(folder, monkeypatch, caplog):
    monkeypatch.setitem(announcing.SECONDS, "test_compiling.doubled", 25)
    monkeypatch.setitem(announcing.WHAT, __name__.rpartition(".")[2], "the doubling")
    doubling()
    assert [each.message for each in caplog.records] == [
        "compiling the doubling (doubled), once on this machine, about 25 s"
    ]
    doubling()
    assert len(caplog.records) == 1
    assert len(announcing.MISSED) == 1


def test_what_is_compiled_in_a_moment_says_nothing(folder, caplog):
    doubling()
    assert not caplog.records


def test_it_is_known_of_every_kernel_what_it_is_for_and_how_long_it_takes():
    names = {each.full_name for each in every_kernel()}
    assert names == set(announcing.SECONDS)
    assert {name.partition(".")[0] for name in names} == set(announcing.WHAT)


def test_the_command_warms_up_and_says_what_it_did(folder, monkeypatch, capsys):
    monkeypatch.setattr(kernel_module, "every_kernel", lambda: [Kernel(__name__, "doubled")])
    monkeypatch.setattr(kernel_warmup, "CLASSES", ())
    warmup_command()
    assert "compiled 1 function;" in capsys.readouterr().out
    announcing.MISSED.clear()
    warmup_command("panda")
    assert "everything had been compiled before" in capsys.readouterr().out


def test_after_the_warmup_of_a_robot_nothing_is_compiled_for_it(monkeypatch):
    kernel_warmup.warmup(PANDA)
    monkeypatch.setattr(object_files, "compiled", lambda *_: pytest.fail("compiled"))
    monkeypatch.setattr(announcing, "announce", lambda *_: pytest.fail("compiled"))
    q = np.stack([PANDA.rest] * 20)
    J = PANDA.jacobian(q)
    stepper = rik.Stepper(PANDA, rik.JParse())
    assert stepper.compiled
    for each in (
        stepper.step(PANDA.rest, np.ones(6)),
        PANDA.pose(q),
        PANDA.hessian(q),
        rik.svd(J).s,
        rik.JParse().solve(J, np.ones((20, 6))),
    ):
        assert np.isfinite(each).all()


@pytest.mark.parametrize(
    "n, sizes", [(2, {8}), (8, {8}), (9, {8, 16, 32}), (16, {8, 16, 32}), (17, {8, 32}), (33, {8})]
)
def test_only_kernels_of_other_sizes_are_left_out(n, sizes):
    assert {most for most in (8, 16, 32) if kernel_warmup._serves(most, n)} == sizes
    assert kernel_warmup._serves(None, n)
    assert {each.most for each in every_kernel()} == {None, 8, 16, 32}


def test_what_names_more_than_numbers_and_functions_is_compiled_by_every_process(monkeypatch):
    for other in (np.ones(3), np.float32(2.0), rik, object()):
        monkeypatch.setitem(globals(), "FACTOR", other)
        assert kernel_store.sources_of(scaled, "") is None
