"""Sensors as LeafSystems; those of a few numbers are an Instrument in a NoisySensor."""
