"""The Home screen: an overview of the flight."""
