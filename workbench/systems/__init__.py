"""The LeafSystems of the flight diagram, a noun a file, and the pure functions they call."""
