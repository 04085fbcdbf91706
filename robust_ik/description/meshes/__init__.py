"""Mesh files, read safely: coloured triangles to draw, vertices to measure."""
