"""A process that judges gains beside a flight: what a screen asks for, it computes."""
