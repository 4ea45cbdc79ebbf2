"""Judge every control loop of the flying system."""
