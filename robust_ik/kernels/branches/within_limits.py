"""Solutions within joint limits: turns are chosen, stand-ins are dropped, and the nearest solution comes first."""

from __future__ import annotations

import math

from robust_ik.kernels.branches import branches_layout as lay
from robust_ik.kernels.branches.branches_layout import JOINTS
from robust_ik.kernels.branches.group_closing import SAME
from robust_ik.kernels.branches.loop_state import change
from robust_ik.kernels.chain.full_turns import turned
from robust_ik.kernels.compiler.compiling import called, inlined
from robust_ik.kernels.compiler.stack_memory import ONE, W16, Pointer, further, sizes, stack

AT_LIMIT = 1e-9
"""By how much a joint may pass its limit, rad or units of length; it is put on the limit."""
KEYS = sizes(lay.SOLUTIONS)


@inlined
def is_own(plan: Pointer, q: Pointer) -> bool:
    """Whether the stand-ins that are locked are at 0, so that the arm's own joints reach the pose."""
    largest = 0.0
    for k in range(int(plan[lay.OWN]), JOINTS - int(plan[lay.FLOATING])):
        largest = max(largest, abs(q[k]))
    return largest <= SAME


@inlined
def is_known(plan: Pointer, found: Pointer, kept: int, n: int) -> bool:
    """Whether a solution has the joint values of one that is kept already; those that float may differ."""
    one = further(found, lay.ROW * n)
    for i in range(kept):
        other, far = further(found, lay.ROW * i), 0.0
        for k in range(int(plan[lay.OWN])):
            far = max(far, abs(change(one[k] - other[k], plan[lay.SLIDES + k])))
        if far < SAME:
            return True
    return False


@called
def within(plan: Pointer, near: Pointer, found: Pointer, count: int, numbers: Pointer) -> None:
    """Turns each joint to the value within its limits that is nearest to `near`; sorts by limits and distance."""
    allowed, kept, key, row = 0, 0, stack(0.0, ONE, KEYS), stack(0.0, ONE, W16)
    for each in range(count):
        if not is_own(plan, further(found, lay.ROW * each)) or is_known(plan, found, kept, each):
            continue
        n, inside, far = kept, 1.0, 0.0
        q = further(found, lay.ROW * n)
        kept += 1
        for i in range(lay.ROW):
            q[i] = found[lay.ROW * each + i]
        for k in range(int(plan[lay.OWN])):
            lower, upper = plan[lay.LOWER + k], plan[lay.UPPER + k]
            if not plan[lay.SLIDES + k] > 0.0:
                q[k] = turned(q[k], near[k], lower - AT_LIMIT, upper + AT_LIMIT)
            if q[k] > upper + AT_LIMIT or q[k] < lower - AT_LIMIT:
                inside = 0.0
            else:
                q[k] = min(max(q[k], lower), upper)
            far += (q[k] - near[k]) ** 2
        q[lay.INSIDE], key[n] = inside, far if inside > 0.0 else math.inf
        allowed += 1 if inside > 0.0 else 0
        for i in range(lay.ROW):
            row[i] = q[i]
        place, last = n, key[n]
        while place > 0 and key[place - 1] > last:
            place -= 1
        for later in range(n, place, -1):
            key[later] = key[later - 1]
            for i in range(lay.ROW):
                found[lay.ROW * later + i] = found[lay.ROW * (later - 1) + i]
        key[place] = last
        for i in range(lay.ROW):
            found[lay.ROW * place + i] = row[i]
    numbers[lay.COUNT], numbers[lay.ALLOWED] = float(kept), float(allowed)
