"""From a flight's log to the vehicle that flew it, with an interval for each number."""
