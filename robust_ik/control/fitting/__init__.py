"""How one level's wish is fitted into the bounds: null spaces, the programs, what motion costs, limiters."""
