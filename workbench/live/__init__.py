"""A live flight: simulated in real time in its own process, beside the screen that shows it."""
