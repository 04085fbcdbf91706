"""One velocity step with everything prepared: the stepper and its compiled program."""
