"""Files, progress bars and workers: what the package needs of the machine it runs on."""
