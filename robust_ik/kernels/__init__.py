"""Compiled code for all that has to be fast, written in the part of Python that Numba compiles. Arrays only.

This is the only room that imports Numba, which takes half a second and 60 MB: only modules that define kernels do, and
nothing imports these but what compiles them. What the rest of the package calls is named in the `__init__.py` of each
folder.
Matrices live on the stack, padded: entry (i, c) is at i · width + c. The same code handles one matrix or eight side by
side, so that batches and single calls agree bit for bit. Sums keep their order and no multiply-add is fused, so that
the bits do not depend on the processor.
"""
