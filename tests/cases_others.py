"""One row per inverse that is no plain filter: what the contract tests run over. A new inverse adds its rows here.

Every one takes J of any shape. An instance that does not (weights for so many rows or joints) is tested with its own
kind, in test_other_inverses.py.
"""

from robust_ik.inverses import (
    SDLS,
    ChanLawrence,
    DampedLeastSquares,
    DulebaAdditive,
    FilteredInverse,
    Halley,
    JParse,
    JParsePositionFirst,
    JParseWithGains,
    KelmarKhosla,
    MaciejewskiKlein,
    RobustInverse,
    SecondOrder,
    Sugihara,
    UserDefinedAccuracy,
    Weighted,
)

OTHER_CASES: list[RobustInverse] = [
    DulebaAdditive(),
    DulebaAdditive(squared_damping=0.01, variant="plain"),
    DulebaAdditive(squared_damping=2.0, variant="floored", floor=0.1),
    DulebaAdditive(squared_damping=0.01, variant="floored"),
    Weighted(JParse()),
    Weighted(DampedLeastSquares(), length_scale=0.3, linear_rows=1),
    Weighted(Weighted(JParse(), length_scale=2.0, linear_rows=0)),
    UserDefinedAccuracy(),
    UserDefinedAccuracy(sacrificed=0, least_weight=0.01, threshold=0.3, damping=0.02),
    SDLS(),
    SDLS(clamp="smooth", length_scale=0.3),
    SDLS(max_angle=0.1),
    KelmarKhosla(),
    KelmarKhosla(ratio=0.9, floor=0.05),
    ChanLawrence(),
    ChanLawrence(gain=0.1),
    Sugihara(),
    FilteredInverse(),
    FilteredInverse(rate=5.0, leakage=0.1, initial=None),
    MaciejewskiKlein(),
    MaciejewskiKlein(directions=1, threshold=0.3, damping=0.1, floor=0.02),
    Halley(),
    Halley(inverse=DampedLeastSquares(), horizon=0.01),
    JParseWithGains(),
    JParseWithGains(gamma=0.3, position_gain=9.0, orientation_gain=1.0),
    JParsePositionFirst(),
    JParsePositionFirst(gamma=0.02, position_gain=2.0, orientation_gain=0.5),
    SecondOrder(),
    SecondOrder(gamma=0.3, speed=0.5, acceleration=2.0),
]
