"""Linear models of the closed loop, by exact derivatives of the simulation."""
