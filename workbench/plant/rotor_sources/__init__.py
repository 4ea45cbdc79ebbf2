"""Where rotors are found in a description: one file a way of writing them."""
