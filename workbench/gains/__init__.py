"""Gains: gain files with their history, differences of gains, and the rule for any vehicle."""
