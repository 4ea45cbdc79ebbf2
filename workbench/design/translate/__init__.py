"""Translate gains of one law to another, by their effect on the vehicle."""
