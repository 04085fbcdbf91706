"""How many digits a URDF is written with: the place of the last one, of its lengths and of its angles."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence

from lxml import etree

FINEST = 8
"""Decimal places that are looked at, from the first digit of the largest number: what has more is written in full."""
NOISE = 1e-6
"""Largest distance from whole numbers of the last place, in that place. Floats of FINEST digits are off by 1e-8."""
LEAST = 1e-200
"""Smaller numbers are zero: powers of ten end at 1e-323."""
NOMINAL = math.pi / 12
"""15°: the angles that designs mean are multiples of it."""
PLACED, COARSEST = 0.501, 0.01
"""Half of the last place, and rounding; and the coarsest place, rad: 1.57 is met in files, 1.6 is not."""


def last_places(xml: str, joints: Collection[str]) -> tuple[float, float]:
    """The places of the last digits with which lengths and angles in joints' origins are rounded.

    Args:
        xml: URDF text, with numbers that can be read.
        joints: Names of the joints that count.

    Returns:
        The place of lengths, m, and that of angles, rad, as `rounding_of_angles`: powers of ten; 0 of numbers that are
        written in full, and where there are none.
    """
    origins = [
        origin
        for element in etree.fromstring(xml.encode()).findall("joint")
        if element.get("name") in joints and (origin := element.find("origin")) is not None
    ]
    lengths = [float(word) for origin in origins for word in origin.get("xyz", "").split()]
    angles = [float(word) for origin in origins for word in origin.get("rpy", "").split()]
    return last_place(lengths), rounding_of_angles(angles)


def rounding_of_angles(angles: Sequence[float]) -> float:
    """The place to which angles are rounded, rad; 0 if nothing shows that they are.

    An angle of 1.571 beside none that is longer shows that angles are rounded to 0.001; one of 1.5707963267948966, that
    they are not; one of 0.5 shows nothing.

    Args:
        angles: Angles as they are written, rad.
    """
    turned = [abs(angle) for angle in angles if angle != 0]
    away = [abs(angle - max(round(angle / NOMINAL), 1) * NOMINAL) for angle in turned]
    place = last_place(turned)
    shown = any(each <= PLACED * place for each in away)
    return place if shown and place <= COARSEST else 0.0


def last_place(numbers: Iterable[float]) -> float:
    """The largest power of ten of which all numbers are multiples; 0 if there are no numbers, or no such power."""
    sizes = [abs(number) for number in numbers if abs(number) > LEAST]
    if not sizes:
        return 0.0
    highest = math.floor(math.log10(max(sizes)))
    for exponent in range(highest, highest - FINEST, -1):
        shares = [size / 10.0**exponent for size in sizes]
        if all(abs(share - round(share)) <= NOISE for share in shares):
            return float(f"1e{exponent}")
    return 0.0
