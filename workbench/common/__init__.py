"""Common tools for every package: errors, files, caches, shipped resources, compiled code."""
