# SPDX-License-Identifier: Apache-2.0
"""Random numbers that the tests make, too (scipy_random.hpp)."""


class Random:
    """A linear congruential generator that both sides have (Knuth's MMIX)."""

    def __init__(self, seed):
        self.state = seed

    def uniform(self):
        """A multiple of 2^-24 in [0, 1)."""
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) % 2**64
        return (self.state >> 40) / 2**24
