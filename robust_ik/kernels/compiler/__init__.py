"""How kernels are compiled, kept on disk and announced, and what they are written with."""
