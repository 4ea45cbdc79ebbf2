"""Meshes as Drake takes them, converted in a process of its own."""
