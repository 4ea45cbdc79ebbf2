"""Settings: the user's preferences, and the set-up of the flight."""
