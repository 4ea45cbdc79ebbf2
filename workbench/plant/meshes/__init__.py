"""Convert meshes for Drake, in a separate process."""
