"""Robust inverses, one in each file; `base` has what they share, CONTRIBUTING.md how to add one."""

from robust_ik.inverses.ablations import Ablation, jacobian_projection, jacobian_safety, jacobian_safety_projection
from robust_ik.inverses.base import Card, Jump, RobustInverse, SingularValueFilter
from robust_ik.inverses.chiaverini import Chiaverini
from robust_ik.inverses.chiaverini_filtering import ChiaveriniFiltering
from robust_ik.inverses.damped_least_squares import DampedLeastSquares
from robust_ik.inverses.duleba_additive import DulebaAdditive
from robust_ik.inverses.duleba_clamp import DulebaClamp
from robust_ik.inverses.edls import EDLS
from robust_ik.inverses.error_damped import ChanLawrence, Sugihara
from robust_ik.inverses.esrim import ESRIM
from robust_ik.inverses.esrim_tracking import TrackingLoop, TrackingReport
from robust_ik.inverses.filtered_inverse import FilteredInverse
from robust_ik.inverses.gain_formula import GainFormula
from robust_ik.inverses.halley import Halley
from robust_ik.inverses.jparse import JParse
from robust_ik.inverses.jparse_gains import JParsePositionFirst, JParseWithGains
from robust_ik.inverses.kelmar_khosla import KelmarKhosla
from robust_ik.inverses.maciejewski_klein import MaciejewskiKlein, SmallestSingularValues
from robust_ik.inverses.moore_penrose import MoorePenrose
from robust_ik.inverses.nakamura_hanafusa import NakamuraHanafusa
from robust_ik.inverses.sdls import SDLS
from robust_ik.inverses.second_order import Exit, SecondOrder
from robust_ik.inverses.sigmoid import Sigmoid
from robust_ik.inverses.truncated_svd import TruncatedSVD
from robust_ik.inverses.user_accuracy import UserDefinedAccuracy
from robust_ik.inverses.weighted import Weighted
from robust_ik.kernels.compiler.where import where

CLASSES: tuple[type[RobustInverse], ...] = (
    MoorePenrose,
    TruncatedSVD,
    DampedLeastSquares,
    JParse,
    NakamuraHanafusa,
    Chiaverini,
    ChiaveriniFiltering,
    DulebaClamp,
    EDLS,
    ESRIM,
    Sigmoid,
    DulebaAdditive,
    Weighted,
    UserDefinedAccuracy,
    SDLS,
    KelmarKhosla,
    ChanLawrence,
    Sugihara,
    FilteredInverse,
    MaciejewskiKlein,
    Halley,
    JParseWithGains,
    JParsePositionFirst,
    SecondOrder,
)
"""Every inverse, filters first; all but Weighted can be made without arguments."""

__all__ = [
    "CLASSES",
    "EDLS",
    "ESRIM",
    "SDLS",
    "Ablation",
    "Card",
    "ChanLawrence",
    "Chiaverini",
    "ChiaveriniFiltering",
    "DampedLeastSquares",
    "DulebaAdditive",
    "DulebaClamp",
    "Exit",
    "FilteredInverse",
    "GainFormula",
    "Halley",
    "JParse",
    "JParsePositionFirst",
    "JParseWithGains",
    "Jump",
    "KelmarKhosla",
    "MaciejewskiKlein",
    "MoorePenrose",
    "NakamuraHanafusa",
    "RobustInverse",
    "SecondOrder",
    "Sigmoid",
    "SingularValueFilter",
    "SmallestSingularValues",
    "Sugihara",
    "TrackingLoop",
    "TrackingReport",
    "TruncatedSVD",
    "UserDefinedAccuracy",
    "Weighted",
    "jacobian_projection",
    "jacobian_safety",
    "jacobian_safety_projection",
    "where",
]
