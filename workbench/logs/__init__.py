"""A flight as a file: MCAP, which viewers open, and from which it is flown again to the bit."""
