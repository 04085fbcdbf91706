"""Small matrices in compiled code: singular values, least squares, reflections."""
