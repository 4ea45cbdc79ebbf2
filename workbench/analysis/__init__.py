"""Processes that evaluate gains beside a flight, as a screen requests."""
