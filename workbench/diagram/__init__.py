"""The wiring: the only room that connects systems of different rooms, as Drake diagrams."""
