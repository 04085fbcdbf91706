"""Checks a proof by arithmetic of its own, modulo primes."""
