"""Starts a child process and exchanges messages with it."""
