"""Chains of joints and what follows from their Jacobians: arrays only, no robot."""
