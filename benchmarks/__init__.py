"""Measurements: each is run by itself, `python -m benchmarks.NAME`, and prints a table."""
