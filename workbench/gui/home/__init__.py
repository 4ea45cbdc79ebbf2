"""The Home screen: all of a flight at a glance."""
