"""Building the extension's zips: what they carry is locked in wheels.toml; `python -m extension.build`."""
