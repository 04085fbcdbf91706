"""From singular configurations to families: conditions on joints, leaves, strata."""
