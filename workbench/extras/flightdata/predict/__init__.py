"""Predictions of flown flights by a model, and of the same flights with other gains."""
