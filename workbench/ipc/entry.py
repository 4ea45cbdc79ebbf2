"""The entry of a child process: `python -m workbench.ipc.entry MODULE ARGUMENTS`."""

import runpy
import sys

from workbench.common.import_path import own_packages_first

if __name__ == "__main__":
    own_packages_first()
    del sys.argv[0]
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
