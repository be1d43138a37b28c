"""What only a window can show: the modal operators, cancelling, undo and redo. Run by Blender with a window:

    blender --factory-startup --python tests/addon/run_in_window.py

Prints one line for each check, then how many failed, and quits, with exit code 1 if one failed. Names of checks after
`--` run only those. The Escape key is pressed with xdotool, and files are dragged with python-xlib; without them, or
without an X display, those checks are reported as not run.
"""
import os
import sys
from pathlib import Path

sys.path.insert(0, os.environ.get("NPM_ROOT", str(Path.cwd())))

from tests.addon import (  # noqa: E402 - found in the folder above
    window_decoded,
    window_driver,
    window_drops,
    window_jobs,
    window_preview,
)

CHECKS = [function for module in (window_jobs, window_drops, window_preview, window_decoded)
          for name, function in vars(module).items() if name.startswith("check_")]
names = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
window_driver.run([check for check in CHECKS if not names or check.__name__ in names])
