"""A proof as data: cases, their leaves, and what is read from them."""
