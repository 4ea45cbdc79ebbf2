"""The server: let others watch and fly, and see who is connected."""
