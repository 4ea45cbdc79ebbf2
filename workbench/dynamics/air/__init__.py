"""The air: wind, gusts and turbulence, and what they do to body and rotors; and pushes."""
