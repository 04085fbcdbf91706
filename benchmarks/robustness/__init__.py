"""The neutral benchmark of singularity-robust control: twelve arms, every inverse, other packages, tuned and not."""
