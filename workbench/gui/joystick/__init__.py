"""Fly with two sticks: on the screen, on the keyboard, or on a game pad."""
