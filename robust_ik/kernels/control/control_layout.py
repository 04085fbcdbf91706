"""Layout of a controller's two vectors: the program, which says what is done, and the desk, on which it is done."""

from __future__ import annotations

JOINTS, LEVELS, DT = 0, 1, 2
"""Number n of joints, number of levels, length of a step in s; 0 if unknown."""
LIMITER, STEADY, RELEASE, RISE = 3, 4, 5, 6
"""The limiter, whether levels are kept from overshooting, the fraction of σ₁ up to which directions are released, and
how much the joint speed of a stopped level may grow in a step; 0 for a limiter that stops none."""
ROWS, HAS_SPEEDS, HURRIED = 7, 8, 9
"""Number of rows of the bounds, whether there are pure speed limits, whether there are acceleration limits."""
LOWER, UPPER, SPEEDS, LAST = 10, 11, 12, 13
"""Places on the desk, n numbers each: the box, pure speed limits, the last velocities."""
LONG_LOWER, LONG_UPPER = 14, 15
"""Places of the box without acceleration limits."""
BOUND_ROWS, FLOOR = 16, 17
"""Places of the rows of the bounds and, so many numbers each, of their floors, of those that were asked for, and of
marks at those that are not kept, see FIRST_STAGE."""
QDOT, MOTION, SCRATCH, EASED = 18, 19, 20, 21
"""Places of the joint velocities, of a level's motion, of room for a program, of the levels' last speeds."""
CONFIGURATION, LENGTH, MAP = 22, 23, 24
"""Length of q, the unit of length in m, and the place in the program of three numbers a joint, see FIRST."""
FRAMES, FRAME = 25, 26
"""Number of frames, and the place in the program of two numbers a frame: the place of its chain in the program, and of
its pose and Jacobian on the desk."""
LIMITS = 27
"""Place in the program of the joint limits, see ACCELERATION; 0 if bounds come from outside."""
ASKED, BEFORE = 28, 29
"""Places of q, and of the last velocities, of the step that is on the desk: for its report."""
MADE = 30
"""How many steps have been made."""
RESOLVER = 31
"""How the levels are resolved, see WALK."""
WAY_BACK, COMPENSATED = 32, 33
"""Of reconstructed tasks: the speed of the way back up, and whether other levels' changes of a measure are made up for.
"""
CALM, TURNING = 34, 35
"""The place on the desk of what is remembered of joints that turn back, see CALM_SHARE; and the place in the program of
the speed from which on a joint's turning counts and of how much longer it is remembered, (2, n); 0 if none counts."""
NOTED, EARLIER = 36, 37
"""How much is remembered from step to step, from CALM on: of joints that turn back, then of levels of second order, see
MEMORY; and the place on the desk of what was remembered before the step."""
FIRST_STAGE, SECOND_STAGE = 1, 2
"""What is added to the mark of a row that is not kept where the levels begin, and where acceleration limits do."""
HEAD = 40
"""Numbers before the records of the levels."""

M, WAY, GAIN, PARAMETERS, RELATIVE = 0, 1, 2, 3, 4
"""In a level's record: its number of rows, how its motion is found, address and parameters of its gain formula, whether
thresholds are relative to σ₁."""
X, JACOBIAN, MISSING, RESIDUAL = 5, 6, 7, 8
"""Places on the desk of ẋ and J, of what the level still misses of ẋ, and of what it misses at the end."""
LEFT, SIGMA, OWN, RIGHT, AIM, FOUND = 9, 10, 11, 12, 13, 14
"""Places on the desk of U, σ, the σ of J itself, Vt, the velocities aimed at, and of the numbers found, see FREE."""
ERROR, TASKS, TASK = 15, 16, 17
"""Place on the desk of the error, number of the level's tasks, and the place in the program of the first one."""
LEVEL_WEIGHT, BOUND, SLOPE = 18, 19, 20
"""The level's weight beside others; the bound of its measure, 0 for none; the place on the desk of the gradient of its
measure, (n,)."""
MEMORY, CURVATURE, BLIND = 21, 22, 23
"""Of a level of second order: the places on the desk of its memory, see `second_order_layout.MEMORY_ROWS`, and of ∂J/∂q
of rows from outside, (m, n, n), but for the units of the joints; and whether ∂J/∂q of some of its rows is not known."""
RECORD = 24
"""Length of a level's record."""

FIRST, TURNS, UNIT = 0, 1, 2
"""Of a joint: its first place in q, whether q holds cosine and sine there, the unit of its motion."""
MAPPED = 3
"""Numbers of a joint."""

CALM_SHARE, CALM_NOW = 0, 1
"""Of the memory of joints that turn back: the share of their velocities that tasks ask for, in the next step and in the
one that is on the desk."""
CALM_TASKS, CALM_STILL, CALM_FREE, CALM_GONE = 2, 3, 4, 5
"""A sum of the tasks' numbers, 0 if unknown, the time since it has last changed, s, whether it has since joints last
shook; and how far the joint that is farthest from there has got."""
CALMING, REMEMBERED = 6, 8
"""Then n numbers each: the largest velocity since a joint has last turned back, how often it has, the speed before it
did, its way since joints last shook, its last velocity, the largest ones before it has last turned back and before it
did so the time before, and how often in a row it has turned back evenly."""
SHAKES, AGAIN, FORGETTING = 4.0, 2.0, 1.0
"""A joint shakes that has turned back so many times, or so many times while the share is below 1; the share grows while
all counts are below FORGETTING. Chosen: motions that curve, stop and correct themselves turn back once or twice.
"""
QUIET, QUIET_STILL, STILL, REVERSALS = 0.5, 2.0, 1.0, 7.0
"""Time in which counts fade, s, and that for tasks that have wanted the same for so long, s; it is longer by the time
for so many changes from rest to the speed before, as fast as acceleration limits allow. Chosen: a joint that goes on
turning back seven times a second, twice a second on its way to one target, or each time as fast as it can, shakes; one
that is waved to and fro twice a second does not.
"""
PATIENCE, QUIET_MOST = 4.0, 60.0
"""For tasks that have wanted the same for long, counts fade in that time over PATIENCE, at most in QUIET_MOST, s.
Chosen: what swings with a period of 20 s is at last counted, and motions that arrive within eight seconds are not
calmed any sooner. With more patience an arm swings for longer; with counts that never fade, noise would add up.
"""
EVEN, IN_A_ROW, SMALL = 0.01, 8.0, 0.02
"""A joint turns back evenly if the largest velocity before is the same as two turns earlier, to that part; if it did so
so many times in a row, speeds above that part of the one that counts do count. Chosen: noise does not make it in ages,
a swing that neither grows nor fades always does, and what is left of it is below 1e-3 rad/s.
"""
KICK = 40.0
"""A joint that turns back in one step by so many times the speed that counts shakes at once, if its tasks have wanted
the same for STILL. Chosen: by a fifth of its speed limit; near its target nothing is that sudden but a kick."""
SOFT, RISING = 0.04, 0.05
"""The joint speed of a level that was stopped rises from rest by SOFT, rad/s², and faster as it grows, e-fold in
RISING, s; see `limiters.RISE`. Chosen: an arm that starts in a step of 20 ms and is stopped again is slower than 1e-3
rad/s, and after 0.2 s it speeds up as fast as it may.
"""
LESS, LESS_AGAIN, LEAST_SHARE = 0.8, 0.5, 1e-8
"""Factors of the share each time that a joint shakes, while it is 1 and below, and the smallest share. Chosen: across a
singularity, where it is a step function, the exact inverse shakes as the root of the share."""
AWAY, GROWTH = 0.04, 0.2
"""How far a joint has to get from where it shook for the share to grow e-fold, rad or units of length; and the time in
which it does so for tasks that want something else, s. Chosen: from a hundredth the arm is then at its full speed
within 1 s, while one that creeps along a singularity is not let go so fast that it shakes hard before it is calmed."""

ACCELERATION, SPEED, LEAST, MOST_VALUE = 0, 1, 2, 3
"""Of the joint limits: n numbers each, one kind after the other: acceleration, speed, lower end, upper end."""
RECOVERY, RATE = 0, 1
"""After them: speed of a joint that comes back, and the largest rate at which the way to an end is used up."""

KIND, LONG, HEIGHT, WEIGHT, GAIN_OF, PLACE = 0, 1, 2, 3, 4, 5
"""Of every task: its kind, the length of its record, its number of rows, its weight, its gain, the number of its frame.
"""
GIVEN, POSE, TWIST, JOINT_VALUES, DIRECTION, CLIMB = 0, 1, 2, 3, 4, 5
"""Kinds of tasks; the rows of GIVEN ones come from outside."""
ROOT, LINEAR, ANGULAR, AXES, ROTATION = 6, 7, 8, 9, 10
"""Of tasks of a frame: the root's frame, −1 for none; caps of errors; axes of the rows; how the rotation counts."""
WORLD_AXES, TARGET_AXES, FRAME_AXES = 0, 1, 2
"""Axes of rows: the world's or the root's, the target's, the frame's."""
NO_ROTATION, SWING, WHOLE_ROTATION = -1, 0, 3
"""How the rotation counts: not, or but for a turn about axis i (SWING + i), or as a whole."""
CHOSEN, FORWARD, GOAL = 11, 17, 23
"""Then six places of rows, six numbers of feed-forward or of a twist, and the target, (4, 4)."""
POSED = 39
"""Length of the record of a task of a frame."""
AXIS, TOWARDS = 11, 14
"""Of a task of a direction, after the caps: the axis in the frame, and the direction in the world."""
DIRECTED = 17
"""Length of its record."""
SOURCE, FASTEST, ENTRIES = 6, 7, 8
"""Of a task of joints: where its errors come from, its largest speed; then the entries of its rows, see JOINT."""
TO_VALUE, TO_RANGE, AT_REST = 0, 1, 2
"""Where errors come from: from values, from the ends of a range, or from nowhere."""
JOINT, FROM, TO = 0, 1, 2
"""Of a row: the joint, and its value, or the ends of its range."""
ENTRY = 3
"""Numbers of a row."""
MEASURE, THRESHOLD, TOP_SPEED, INDEX, SCALE = 6, 7, 8, 9, 10
"""Of a task that climbs: the measure, its threshold, the largest speed, which σ, and the factor of angular rows."""
OF_SIGMA, OF_PRODUCT = 0, 1
"""Measures: a singular value, or the product of all."""
COUNT_OF_ROWS, CHOSEN_ROWS = 11, 12
"""Then the number of rows of the measure, and six places of rows."""
CLIMBING = 18
"""Length of its record."""

WALK, WEIGHTED = 0, 1
"""How levels are resolved: one after another, or all at once by their weights."""
IN_FREEDOM, DECOUPLED, OUTSIDE, RECONSTRUCTED, CURVED, CURVED_DECOUPLED = 0, 1, 2, 3, 4, 5
"""How a level's motion is found: by a gain formula of J N, or of J and then projected; outside of compiled code; by
a gain formula of J N for a velocity that keeps measures above their bounds; or to second order in J N, or in J and then
projected."""
SLIDING, SATURATION, SCALING, NEAREST, KEEPING = 0, 1, 2, 3, 4
"""Limiters."""

FREE, RANK, CLOSED, COUNT, SHARE, LOW = 0, 1, 2, 3, 4, 5
"""What is found of a level: dimension of its freedom, its rank, how many directions are closed to lower levels, how
many singular values it has, the share of its motion, and its measure if that is below its bound and its gradient is
known, else 0; of a level of second order, whether its motion is no numbers."""
NUMBERS = 8
"""Room for them."""

DONE = 0
"""Status of a step that is made."""
NOT_FINITE, OFF_CIRCLE, UNLIKE, NOT_RIGID, TOO_LARGE, UNCERTAIN = 1, 2, 3, 4, 5, 6
"""Other statuses: numbers of q or of a task are not finite, a cosine and sine are not of length 1, arguments are no
vectors of doubles of the right lengths, a target is no rigid pose, velocities are too large, NumPy has to decide."""
BEGIN = -1
"""The level from which a whole step begins, with its tasks and bounds."""
WANTS_MOTION = 16
"""WANTS_MOTION + i: level i needs its motion from outside."""

MOST = 32
"""Most joints, and most rows of a level."""
