"""Where logs and pictures go."""

from pathlib import Path

from workbench.gui.preferences import Preferences


def log_folder(preferences: Preferences) -> Path:
    """Return the folder that the user prefers, or where the app was started."""
    chosen = preferences.text("log_folder")
    return Path(chosen).expanduser() if chosen else Path.cwd()
