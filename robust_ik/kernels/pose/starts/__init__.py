"""Where compiled searches for a pose begin."""
