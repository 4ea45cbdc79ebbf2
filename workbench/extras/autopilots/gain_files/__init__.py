"""Gains in the files of autopilots: PX4, ArduPilot, Betaflight and Crazyflie."""
