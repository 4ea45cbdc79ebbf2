"""The vehicle's motion as pure functions: rotors, air, rigid body."""
