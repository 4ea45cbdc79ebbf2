"""Gains: profiles with their history, their differences, and the rule for any vehicle."""
