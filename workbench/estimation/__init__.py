"""What the flight computer makes of its sensors, as pure functions: filters and estimators."""
