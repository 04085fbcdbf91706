"""Analysis of inverses and configurations: explanations, measures from papers, stability."""

from robust_ik.analysis import evaluation as evaluation
from robust_ik.analysis import stability as stability
