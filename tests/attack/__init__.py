"""Attacks: hostile and clumsy input in great numbers, each kind in a module of its own: `make attack`.

A module is an attack if it has a function

    attack(count: int, seed: int, say: Callable[[str], None]) -> list[str]

which tries `count` things drawn from `seed` and returns what went wrong, a sentence each; `say` tells what it is at.
It may have COUNTS = {"short": …, "full": …}, how many things the two scales try (else `running.COUNTS`), and CHUNK, how
many one process tries at a time (else `running.CHUNK`). Warnings are errors, and memory is bounded.
"""
