"""Runs attacks in processes of their own, so that one that hangs, dies or eats memory is a finding and no end."""

import importlib
import multiprocessing
import pkgutil
import time
import traceback
import warnings
import zlib
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field

import tests.attack
from tests.attack.guards import TooSlowError, limit_memory

COUNTS = {"short": 200, "full": 100_000}
CHUNK = 2_000
SILENCE = {"short": 300, "full": 1_800}
"""Seconds after which a process that says nothing is ended."""


@dataclass
class Outcome:
    """What came of an attack."""

    name: str
    tried: int = 0
    seconds: float = 0.0
    failures: list[str] = field(default_factory=list)


def names():
    """The modules that attack."""
    found = (module.name for module in pkgutil.iter_modules(tests.attack.__path__))
    return [name for name in found if not name.startswith("_") and hasattr(module_of(name), "attack")]


def module_of(name):
    return importlib.import_module(f"tests.attack.{name}")


def chunks(name, scale):
    """(count, seed) of every process of an attack: the same things, however many run at a time."""
    module = module_of(name)
    total, size = getattr(module, "COUNTS", COUNTS)[scale], getattr(module, "CHUNK", CHUNK)
    first = zlib.crc32(name.encode()) % 1_000_000 * 10_000
    return [(min(size, total - done), first + i) for i, done in enumerate(range(0, total, size))]


def run(name, scale="short", jobs=1, say=lambda text: None, done=lambda count: None):
    """The outcome of one attack."""
    outcome, before = Outcome(name), time.perf_counter()
    with ThreadPoolExecutor(jobs) as pool:
        waiting = {pool.submit(chunk, name, *each, SILENCE[scale], say): each[0] for each in chunks(name, scale)}
        for future in as_completed(waiting):
            outcome.failures += future.result()
            outcome.tried += waiting[future]
            done(waiting[future])
    outcome.seconds = time.perf_counter() - before
    return outcome


def chunk(name, count, seed, silence, say):
    """What goes wrong with so many things from that seed, tried in a process of its own."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(name, count, seed, there), daemon=True)
    process.start()
    there.close()
    last = "nothing"
    try:
        while here.poll(silence):
            kind, content = here.recv()
            if kind == "done":
                return content
            last = content
            say(content)
        return [f"said nothing for {silence} s, last {last} (seed {seed})"]
    except EOFError:
        process.join()
        return [f"died with exit code {process.exitcode} after {last} (seed {seed})"]
    finally:
        process.kill()
        process.join()
        here.close()


def _work(name, count, seed, pipe):
    try:
        module = module_of(name)
        warnings.simplefilter("error")
        if getattr(module, "LIMITED", True):
            limit_memory()
        failures = [str(each)[:1000] for each in module.attack(count, seed, lambda text: pipe.send(("at", str(text))))]
    except (Exception, TooSlowError) as error:
        place = "".join(traceback.format_exception(error)[-3:])[-1500:]
        failures = [f"the attack itself failed (seed {seed}): {place}"]
    pipe.send(("done", failures))
