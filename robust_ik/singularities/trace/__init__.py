"""Along families: curves, the nearest singular configuration, paths within limits."""
