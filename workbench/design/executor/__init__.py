"""Flights of the full diagram, flown here or on other machines through one interface."""
