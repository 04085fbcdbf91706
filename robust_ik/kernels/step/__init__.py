"""One velocity step in compiled code."""
