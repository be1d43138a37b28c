"""`python -m npm_blender VERB ...`: see `npm_blender.cli`."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
