"""Constants of the second-order inverse, and the layout of the vectors of doubles that its kernel works on."""

from __future__ import annotations

FLOOR = 1.5e-3
"""λ of the weak rows, relative to σ₁: noise of the command moves joints by at most 1/(2 λ) of it."""
SHORTEST, STEPS = 0.02, 4
"""The shortest look-ahead: seconds, and time steps. Several keep a loop that is late or noisy from overshooting."""
BENT = 4.0
"""How soon curvature takes over from damping. Chosen: less damps exits, more lets speeds grow where it is doubtful."""
STIFF = 1e-6
"""Least κ to divide by."""
ROUNDS, TRIES = 25, 6
"""Most Newton steps from a start, and dampings of each. Chosen: 6 are usual, the flattest minima took up to 20."""
ENOUGH = 1e-8
"""A gradient of at most this part of the command ends the steps."""
FARTHEST = 2.0
"""The weak part of a motion is at most this many times as fast as `speed`."""
FLAT, LITTLE = 0.01, 0.25
"""κ, 1/rad relative to σ₁, below which the arm may turn instead; from LITTLE times that on curvature counts.

There no more is asked of it than joints at `speed` can serve, or a command that is large would be damped to nothing.
"""
MOVING = 1e-3
"""A last velocity of more than this part of `speed` decides to which side a symmetric saddle is left."""
HYSTERESIS = 0.05
"""What changing sides costs, relative to (‖c‖/speed)². Chosen: more than noise of 1e-4 rad makes of two equal sides."""
FIRST_COME = 1e-9
"""What a later start costs more than the one before it, relative to ‖c‖²: of equal minima the first one wins."""
LEAST_FADE = 1e-3
"""Null-space motion costs at least this part of the full damping."""
NEARLY = 0.99
"""Entries that differ by less count as equally large, so that rounding does not choose between joints."""
LARGE, TINY = 1e30, 1e-300
"""Commands and curvatures count as at most LARGE, so that products of several stay numbers. TINY is added to divisors.
"""

DEAD, BRISK = 0.01, 0.1
"""Commands of weak rows below the first, rad/s, do not make the arm turn; from the second on it turns at full speed."""
UNSERVED, SERVED = 0.8, 0.5
"""Shares of the command left over: above the first the arm turns, below the second it does not."""
LEAST_TURN = 0.005
"""Turning rates up to this, 1/rad, are none: a planar arm told to leave its plane."""
PATIENCE = 0.25
"""Seconds without progress before the arm turns, so that what only passes by is left alone."""
HALF_TURN = 3.2
"""Rad of the fastest joint to one side, before the other side is tried, once. Chosen: what a wrist or shoulder has lost
is found after a quarter turn.
"""
EASE = 0.3
"""Rad over which a turn slows down where it changes sides or ends."""
SLOWEST = 0.2
"""A turn counts as at least so much of its full speed, so that slowing down does not stop it short of its end."""
AGAINST = 0.1
"""Share of the command by which a turn may move the tool the other way."""
OTHER = 0.7
"""Cosine between two commands below which the second is another one: what was tried for the first does not count."""
SETTLED = 1.0
"""Seconds of progress after which everything may be tried again."""

GAMMA, SPEED, ACCELERATION, HORIZON, TURN_SPEED, DT = 0, 1, 2, 3, 4, 5
"""Places of the parameters: γ, `speed`, `acceleration`, `horizon`, the speed of turns in rad/s, the time step in s."""
PARAMETERS = 6
"""How many there are."""

WAITED, PROGRESSED, TURNED, HAS_WAY, HAS_ASKED = 0, 1, 2, 3, 4
"""Places in the memory of a run: what is remembered of a turn, see `turning.Turn`; whether it has a way, a command."""
LAST = 5
"""Then the last velocities and the way of the turn, n numbers each, and the direction of ẋ that it is for, m."""

MEMORY_ROWS, MEMORY_JOINTS, MEMORY_HEAD = 0, 1, 2
"""Before the memory of a level of a stack: the shape of the equation that it is of, which may have a row and a joint
more than the level, 0 if there was none; the memory itself has the places for the level's own shape.
"""

WEAK, FREE, KEPT, SIGMA_1, ASKED, FADE, LOOK_AHEAD, CURVATURE = 0, 1, 2, 3, 4, 5, 6, 7
"""Places on the sheet on which a step is computed: numbers k of weak rows, p of kernel motions and r of kept rows; σ₁,
‖w c‖, the largest fade, τ, κ.
"""
HEAD = 8
"""Numbers before the vectors."""
SIGMA, COMMAND, FADES, REACH, WANTED, MU, KEPT_MOTION, KEPT_SIGMA = 0, 1, 2, 3, 4, 5, 6, 7
"""Vectors: σ of the weak rows relative to σ₁, their command, fades, those of the kernel motions; of the quartic what is
asked, and μ; the motion of the kept rows, and their σ."""
VECTORS = 8
"""How many there are."""
LEFT, RIGHT, SLOPE, CROSS, TURNING, BEND = 0, 1, 2, 3, 4, 5
"""Matrices: U, Vt, of the quartic D, then G, turning rates; last K, one matrix for each weak row."""


def memory_size(m: int, n: int) -> int:
    """Numbers of a memory for m rows and n joints."""
    return LAST + 2 * n + m


def sheet_size(width: int) -> int:
    """Numbers of a sheet for at most so many rows and joints."""
    return HEAD + VECTORS * width + BEND * width**2 + width**3
