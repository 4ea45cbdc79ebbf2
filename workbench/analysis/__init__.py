"""Processes that judge gains beside a flight: they compute what a screen asks for."""
