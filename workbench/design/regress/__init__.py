"""Regression tests of flights: specs of limits, and whether flights meet them."""
