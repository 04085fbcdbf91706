"""A page in which one moves a robot: what it shows is computed here, and the page only draws it."""

from robust_ik.display.live.live_view import LiveView, view

__all__ = ["LiveView", "view"]
