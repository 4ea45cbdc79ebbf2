"""Autopilots that run as programs of their own: how they are built, owned and talked to."""
