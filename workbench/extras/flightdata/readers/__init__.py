"""Readers of logs, one format each, and what they share."""
