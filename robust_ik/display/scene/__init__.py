"""MeshCat scenes: what is drawn, how it moves, kept as a file or shown live."""
