"""What can be said of inverses and of a configuration: explanations, measures of papers, stability."""

from robust_ik.analysis import evaluation as evaluation
from robust_ik.analysis import stability as stability
