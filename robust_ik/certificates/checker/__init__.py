"""Checks proofs by its own arithmetic modulo primes."""
