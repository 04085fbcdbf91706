"""A figure of the gains of filters over singular values."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from robust_ik.checks import Array, checked_parameter
from robust_ik.checks.public_arguments import checked_but
from robust_ik.display.figures.figure_files import save_figure
from robust_ik.errors import InputError
from robust_ik.inverses import SingularValueFilter
from robust_ik.runtime.output_files import check_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEAST_SIGMA = 1e-4
"""Least σ of a curve, as a fraction of σ₁. Chosen: two decades below the usual thresholds of filters, .01 to .1."""
STYLES = ("-", "--", "-.", ":")


@checked_but("filters")
def plot_gains(filters: Sequence[SingularValueFilter], path: str | Path, *, sigma_max: float = 1.0) -> Path:
    """Draws φ(σ) and the share σφ(σ) of the task that is met, for one σ in [0, sigma_max], the others being σ₁.

    Args:
        filters: The filters, at least one.
        path: Image to write: .png, .svg or .pdf.
        sigma_max: σ₁.

    Returns:
        The path.

    Raises:
        InputError: There is no filter, something is not a filter, or the path cannot be written.
    """
    checked_parameter("sigma_max", sigma_max, above=0)
    several = isinstance(filters, (list, tuple)) and len(filters) > 0
    if not several or not all(isinstance(each, SingularValueFilter) for each in filters):
        raise InputError(f"only singular-value filters have gains to draw, at least one is needed, got {filters!r}")
    check_figure(path)
    return save_figure(_drawn(filters, sigma_max), path, dpi=130)


def _drawn(filters: Sequence[SingularValueFilter], sigma_max: float) -> Figure:
    from matplotlib.figure import Figure  # not pyplot, which opens windows and keeps state

    figure = Figure(figsize=(10, 4.6 + 0.2 * -(-len(filters) // 3)), layout="constrained")
    gain, share = figure.subplots(1, 2)
    s = sigma_max * np.geomspace(LEAST_SIGMA, 1, 2001)
    for index, each in enumerate(filters):
        phi = gains_along(each, s, sigma_max)
        style = STYLES[index % len(STYLES)]
        # Ever thinner, so that curves that coincide are all visible.
        width = 4 - 3 * index / len(filters)
        gain.plot(s, np.where(phi > 0, phi, np.nan), linestyle=style, linewidth=width, label=label(each))
        share.plot(s, s * phi, linestyle=style, linewidth=width)
    gain.set(xscale="log", yscale="log", xlabel="σ", ylabel="φ(σ)", title="joint speed per task speed")
    share.set(xscale="log", xlabel="σ", ylabel="σ φ(σ)", title="share of the task that is met")
    figure.legend(loc="outside lower center", ncols=3, fontsize="small")
    for axes in (gain, share):
        axes.grid(alpha=0.3)
    return figure


def label(inverse: SingularValueFilter) -> str:
    """The inverse's name, with its parameters if one is not the default."""
    return type(inverse).__name__ if inverse == type(inverse)() else repr(inverse)


def gains_along(inverse: SingularValueFilter, s: Array, sigma_max: float) -> Array:
    """φ(σ) for a second singular value s, the first one being σ₁ = sigma_max, (...)."""
    return np.asarray(inverse.gains(np.stack([np.full_like(s, sigma_max), s], axis=-1))[..., 1])
