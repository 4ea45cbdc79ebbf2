"""Readers of logs that others write, a format a file; each returns a FlightRecord."""
