"""The flight in 3-D: Drake's Meshcat page, embedded or in the browser."""
