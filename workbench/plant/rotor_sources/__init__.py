"""Readers of rotors in descriptions, one file for each way to write them."""
