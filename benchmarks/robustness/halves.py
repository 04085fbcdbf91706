"""Measures everyone: as they come and tuned on the training half, both on the held-out half of the arms."""

from __future__ import annotations

from concurrent.futures import Future
from contextlib import suppress

from rich.console import Console
from rich.progress import Progress

from benchmarks.environments import UnavailableError, interpreter
from benchmarks.robustness.arms import HELD_OUT, TRAINING, arm, scenarios
from benchmarks.robustness.contenders import Contender, drawn
from benchmarks.robustness.measuring import measured
from benchmarks.robustness.tuning import tuned
from robust_ik.runtime.parallel import process_pool
from robust_ik.simulation.robustness import BenchmarkResults, RunKey, RunScore, facts


def work(task: tuple[Contender, str, bool]) -> str:
    """Measures one contender on one arm, for others to read what is kept; why not, if it cannot be."""
    contender, name, tuning = task
    try:
        measured(contender, name, tuning=tuning)
    except UnavailableError as error:
        return str(error)
    return ""


def all_measured(tasks: list[tuple[Contender, str, bool]], jobs: int, what: str) -> dict[str, str]:
    """Does tasks in several processes; why contenders could not be measured, by their names."""
    failures: dict[str, str] = {}
    with process_pool(jobs) as pool, Progress(console=Console(stderr=True)) as bar:
        shown = bar.add_task(what, total=len(tasks))
        futures: dict[int, Future[str]] = {}
        if pool is not None:
            futures = {place: pool.submit(work, task) for place, task in enumerate(tasks)}
        for place, task in enumerate(tasks):
            failure = futures[place].result() if pool is not None else work(task)
            if failure:
                failures[task[0].name] = failure
            bar.advance(shown)
    return failures


def measure(
    contenders: list[Contender], jobs: int, tries: int
) -> tuple[BenchmarkResults, dict[str, str], dict[str, Contender]]:
    """Results on the held-out arms of all contenders as they come and tuned; failures; and the tuned ones by name.

    Args:
        contenders: With their defaults.
        jobs: Processes that share the work.
        tries: Settings of each that are tried; 0 for no tuning.
    """
    for script in dict.fromkeys(each.script for each in contenders if each.script):
        with suppress(UnavailableError):  # told by each contender
            interpreter(script)
    for name in (*TRAINING, *HELD_OUT):
        arm(name)
    failures = on_held_out(contenders, jobs, "as they come")
    there = [each for each in contenders if each.name not in failures]
    chosen: dict[str, Contender] = {}
    if tries:
        chosen, more = all_tuned([each for each in there if each.ranges], jobs, tries)
        failures |= more | on_held_out(list(chosen.values()), jobs, "tuned")
    changed = [each for each in chosen.values() if each.parameters]
    return gathered([each for each in (*there, *changed) if each.name not in failures]), failures, chosen


def on_held_out(contenders: list[Contender], jobs: int, what: str) -> dict[str, str]:
    """Measures contenders on the held-out arms; why some could not be, by name."""
    return all_measured([(each, name, False) for name in HELD_OUT for each in contenders], jobs, what)


def all_tuned(contenders: list[Contender], jobs: int, tries: int) -> tuple[dict[str, Contender], dict[str, str]]:
    """Contenders at their best settings, by name, and why others could not be measured."""
    settings = [each for one in contenders for each in (one, *map(one.set_to, drawn(one, tries)))]
    failures = all_measured([(each, name, True) for each in settings for name in TRAINING], jobs, "tuning")

    def on_training(contender: Contender, name: str) -> dict[RunKey, RunScore]:
        return measured(contender, name, tuning=True)

    found = {each.name: tuned(each, on_training, tries)[0] for each in contenders if each.name not in failures}
    return found, failures


def gathered(rows: list[Contender]) -> BenchmarkResults:
    """What is kept of the runs of contenders on the held-out arms."""
    scores: dict[str, dict[RunKey, RunScore]] = {each.label: {} for each in rows}
    told = {}
    for name in HELD_OUT:
        told |= facts(scenarios(name))
        for each in rows:
            scores[each.label] |= measured(each, name)
    return BenchmarkResults(told, scores)
