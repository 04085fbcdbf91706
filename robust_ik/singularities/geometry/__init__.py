"""The screw axes of an arm, and what singular configurations depend on."""
