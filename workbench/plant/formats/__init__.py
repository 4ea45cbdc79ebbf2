"""Readers and writers of file formats: XML, xacro, URDF. Packages add others, see `readers`."""
