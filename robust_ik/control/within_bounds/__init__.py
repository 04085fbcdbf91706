"""Fitting one level's motion into the bounds: null spaces, quadratic programs, the cost of motion, limiters."""
