"""The LeafSystems of the flight diagram, and the pure functions that they call."""
