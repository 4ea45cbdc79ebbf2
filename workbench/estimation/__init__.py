"""State estimation of the flight computer as pure functions: filters and estimators."""
