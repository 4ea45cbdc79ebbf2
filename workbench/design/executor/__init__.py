"""Flights on the full diagram, run locally or on other machines through one interface."""
