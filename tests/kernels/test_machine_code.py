"""Machine code on disk: what it needs of others, and what a process needs to run it."""

import ctypes
import struct
import subprocess
import sys

import pytest

from robust_ik.inverses import CLASSES, GainFormula
from robust_ik.kernels.compiler.compiling import FLOAT, kernel
from robust_ik.kernels.compiler.gain_callbacks import TYPES, address_of
from robust_ik.kernels.loader import kernel_store
from robust_ik.kernels.loader.kernel import every_kernel
from robust_ik.kernels.loader.machine_code import MARK, address_in_process, load

ELF = b"\x7fELF\x02\x01"
SYMBOL_TABLE = 2


def undefined(code):
    """The symbols that an object file of 64-bit ELF uses and does not define."""
    sections, size, count = (*struct.unpack_from("<Q", code, 0x28), *struct.unpack_from("<HH", code, 0x3A))
    headers = [struct.unpack_from("<IIQQQQIIQQ", code, sections + i * size) for i in range(count)]
    (table,) = (each for each in headers if each[1] == SYMBOL_TABLE)
    names = code[headers[table[6]][4] :]
    symbols = [struct.unpack_from("<IBBHQQ", code, table[4] + at) for at in range(0, table[5], 24)]
    return {names[each[0] :].split(b"\0", 1)[0].decode() for each in symbols if each[0] and not each[3]}


def contents():
    """The machine code of all kernels and formulas, compiled if it was not, by name."""
    kinds = [each for each in CLASSES if issubclass(each, GainFormula)]
    wanted = {each.full_name: kernel_store.SOURCES for each in every_kernel()}
    wanted |= {kernel_store.name_of(each.formula): kernel_store.sources_of(each.formula, TYPES) for each in kinds}
    for each in every_kernel():
        assert callable(each.compiled)
    for each in kinds:
        address_of(each.formula)
    files = {name: kernel_store._files(name, sources) for name, sources in wanted.items()}
    return {name: next(filter(None, map(kernel_store._read, paths))) for name, paths in files.items()}


@pytest.mark.slow
def test_kernels_need_nothing_but_the_c_library_and_python():
    found = contents()
    assert len(found) > 30
    for name, content in found.items():
        named, _, code = content.partition(b"\n")
        needed = set(named.removeprefix(MARK).decode().split())
        for each in needed:
            assert each.startswith(("Py", "_Py")) or hasattr(ctypes.CDLL(None), each), (name, each)
            assert address_in_process(each) is not None, (name, each)
        if code.startswith(ELF):
            assert undefined(code) <= needed, name


NAMES = (
    "print(sorted({each.split('.')[0] for each in sys.modules} & {'numba', 'llvmlite'}),"
    " __import__('robust_ik.kernels.loader.announcing', fromlist=['MISSED']).MISSED)"
)
PROGRAMS = {
    "a controller's step": "c = rik.VelocityController(r); c.step(r.rest, [[rik.FrameTask(r.pose(r.rest))]], 0.01)",
    "a loop's step": "rik.ControlLoop(rik.VelocityController(r), [[rik.FrameTask(r.pose(r.rest))]], 0.01).step(r.rest)",
    "a stepper's step": "s = rik.Stepper(r, rik.JParse()); assert s.compiled; s.step(r.rest, np.ones(6))",
    "a pose": "assert r.solve_pose(r.pose(r.rest), r.rest).solved",
    "kinematics of many": "r.jacobian(np.stack([r.rest] * 20))",
}


@pytest.mark.slow
@pytest.mark.parametrize("program", PROGRAMS.values(), ids=PROGRAMS)
def test_what_is_on_disk_is_run_without_numba(program):
    script = f"import sys, numpy as np, robust_ik as rik\nr = rik.load('panda')\n{program}\n{NAMES}"
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "['llvmlite'] []"


@pytest.mark.parametrize(
    "content",
    [b"", b"\n", b"\nno object file", ELF * 20, MARK, MARK + b"\n", MARK + b" no_such_function\n" + b" " * 100],
    ids=str,
)
def test_what_is_no_machine_code_is_an_error_and_not_the_end_of_the_process(content):
    with pytest.raises(Exception, match="."):
        load(content)


@kernel(FLOAT)
def scaled(x):
    return 3 * x


def test_machine_code_is_loaded_as_often_as_one_likes():
    content = scaled.made().content
    addresses = {load(content) for _ in range(3)}
    assert len(addresses) == 3
