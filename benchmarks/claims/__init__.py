"""What the five papers claim, beside what the same experiment gives here: one module for each paper."""
