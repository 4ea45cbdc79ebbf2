"""Readers of other programs' logs, one file per format; each returns a FlightRecord."""
