"""Puts compiled kernels into the wheel if ROBUST_IK_KERNELS names their folder; the wheel is then for one platform."""

from __future__ import annotations

import os
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class KernelsHook(BuildHookInterface):  # type: ignore[type-arg]
    """What hatchling calls when it builds."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002
        """Adds the folder and asks for the tag of this Python and platform."""
        if folder := os.environ.get("ROBUST_IK_KERNELS"):
            build_data["pure_python"], build_data["infer_tag"] = False, True
            build_data["force_include"][folder] = "robust_ik/kernels/shipped"
