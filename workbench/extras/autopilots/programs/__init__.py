"""Autopilots that run as separate programs: how to build, own and talk to them."""
