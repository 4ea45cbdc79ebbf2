"""Extras: packages beside the core, which never imports them; they are found by entry points."""
