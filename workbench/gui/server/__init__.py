"""Let others watch and fly: begin and end the server, and see who is there."""
