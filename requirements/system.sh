#!/bin/sh
# Usage: system.sh PYTHON. Makes sure that PYTHON can import bpy, whose wheel links to X and GL libraries that a bare
# Debian lacks. Installs them where that is allowed, else says what to run. Needs no display.
set -eu
python=$1
packages="libx11-6 libxrender1 libxfixes3 libxi6 libxkbcommon0 libsm6 libgl1"  # ldd of bpy 4.5's module

if "$python" -c "import bpy" >/dev/null 2>&1; then exit 0; fi
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    echo "Blender's module lacks system libraries; installing $packages"
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends $packages >/dev/null
    if "$python" -c "import bpy" >/dev/null 2>&1; then exit 0; fi
fi
echo "Expected Blender's Python module to load, found: $("$python" -c "import bpy" 2>&1 | tail -n 1)" >&2
echo "On Debian run: apt-get install $packages" >&2
exit 1
