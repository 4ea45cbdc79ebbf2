"""Ray casting against the scene for lidars, accurate to a fraction of a millimetre."""
