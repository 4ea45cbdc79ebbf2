"""Autopilots: their laws, mixers and filters, files of gains, and firmware that flies."""
