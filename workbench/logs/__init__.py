"""Flight logs in MCAP, which viewers can open; a log can be replayed to the bit."""
