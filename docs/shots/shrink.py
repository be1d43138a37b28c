"""A screenshot as a small picture for the documentation: 256 colours, chosen for it.

    .venv/bin/python docs/shots/shrink.py SCREENSHOT.png PICTURE.png
"""
import sys

from PIL import Image

with Image.open(sys.argv[1]) as picture:
    picture.convert("RGB").quantize(256, kmeans=3).save(sys.argv[2], optimize=True)
