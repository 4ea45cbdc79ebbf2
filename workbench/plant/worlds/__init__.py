"""Worlds: what stands and moves around the drone, from YAML and from Gazebo's SDF."""
