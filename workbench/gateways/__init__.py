"""Gateways: programs that pass on what a drone's server tells, as ordinary clients of the link."""
