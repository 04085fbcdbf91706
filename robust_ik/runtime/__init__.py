"""What the package needs of the machine it runs on: files, long work and its progress, workers."""
