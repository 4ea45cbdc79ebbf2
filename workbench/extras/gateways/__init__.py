"""Gateways: programs that pass on the data of a drone's server, as ordinary clients of the link."""
