"""Debian packages: installed if the user may and agrees, otherwise named in a sentence."""

import os
import shutil
import subprocess
import sys

CONSENT = "WORKBENCH_APT"
"""An environment variable: `yes` agrees for those whom nobody can ask, as in CI."""


def leave(sentence):
    """Say what is wrong and what to do, and end with exit code 2."""
    print(sentence, file=sys.stderr)
    sys.exit(2)


def install(packages, reason):
    """Install `packages`, or leave with the line that would.

    Args:
        packages: names of Debian packages.
        reason: what is missing, the beginning of a sentence.
    """
    packages = sorted(packages)
    names = " ".join(packages)
    if shutil.which("apt-get") is None:
        leave(f"{reason}: install what Debian calls {names}, then run make again.")
    as_root = _as_root()
    if as_root is None or not _agreed(f"{reason}. Install {names} with apt-get?"):
        leave(f"{reason}: run `sudo apt-get install {names}`, then run make again.")
    print(f"{reason}: installing {names} ...", flush=True)
    get = [*as_root, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq"]
    command = [*get, "install", "-y", "--no-install-recommends", *packages]
    done = _run(command)
    if done.returncode != 0:  # a fresh system has no package lists yet, or old ones
        _run([*get, "update"])
        done = _run(command)
    if done.returncode != 0:
        said = "\n".join(done.stdout.strip().splitlines()[-5:])
        leave(
            f"{said}\n{reason}, and installing it failed, as apt-get says above: "
            f"run `sudo apt-get install {names}`, then run make again."
        )


def _agreed(question):
    """Return whether the user says yes, or has said so before."""
    if os.environ.get(CONSENT) == "yes":
        return True
    if not sys.stdin.isatty():
        return False
    print(f"{question} [y/N] ", end="", flush=True)
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _as_root():
    """Return what to put before a command to run it as root, None if the user may not."""
    if os.geteuid() == 0:
        return []
    sudo = shutil.which("sudo")
    if sudo and subprocess.run([sudo, "-n", "true"], capture_output=True).returncode == 0:
        return [sudo, "-n"]
    return None


def _run(command):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
