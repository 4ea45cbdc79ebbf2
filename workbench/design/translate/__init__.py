"""Gains of one law from those of another, by what they mean for the vehicle."""
