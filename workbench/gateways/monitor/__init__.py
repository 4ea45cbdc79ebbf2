"""A served flight in a terminal: live values, and flying by keys; without Drake and Qt."""
