"""`make check-extension`: the built zip, installed and used in a Blender of factory settings.

    BLENDER=path python -m extension.check_install

Without a Blender it says "not run" and succeeds. BLENDER may also be words that start one. Needs the zip: make extension,
or, for a Debian Blender, make extension DEBIAN=1.
"""
import os
import shlex
import shutil
import subprocess
import sys

from .staging import ROOT


def main() -> int:
    """Exit code: that of the checks, 0 where there is no Blender."""
    words = shlex.split(os.environ.get("BLENDER", "")) or [shutil.which("blender")]
    if words == [None] or shutil.which(words[0]) is None:
        print("not run: installing and using the extension, as no Blender is at hand; give BLENDER=path")
        return 0
    command = [*words, "-b", "--factory-startup", "--python-exit-code", "1", "-P", "extension/in_blender.py"]
    return subprocess.run(command, cwd=ROOT).returncode


if __name__ == "__main__":
    sys.exit(main())
