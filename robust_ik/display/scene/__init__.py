"""MeshCat scenes: drawing, motion, files and live display."""
