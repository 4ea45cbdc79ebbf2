"""The air: wind, gusts and turbulence, their effect on body and rotors; and pushes."""
