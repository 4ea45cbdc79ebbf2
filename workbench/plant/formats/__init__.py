"""Readers and writers of file formats: XML, xacro, URDF, SDF, MJCF."""
