"""Settings: what the user prefers, and what flies."""
