"""What every room may use: errors, files, caches, shipped resources, compiled code."""
