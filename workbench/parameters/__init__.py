"""The live parameters of a flight."""
