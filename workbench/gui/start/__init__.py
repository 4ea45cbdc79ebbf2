"""The start page: drones, scenarios and recent flights as cards, and a drone from a data sheet."""
