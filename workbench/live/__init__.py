"""A flight that keeps real time in a process of its own, beside a screen that paints."""
