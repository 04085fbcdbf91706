"""Other systems, each run by its own interpreter: these files import nothing of robust_ik but robust_ik_step.py."""
