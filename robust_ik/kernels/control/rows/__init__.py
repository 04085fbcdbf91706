"""Rows of tasks in compiled steps: what frames and joints shall do, their Jacobians and what those change by."""
