"""The version of the package, in a file of its own: whoever wants to know it loads nothing else."""
__version__ = "0.1.0"  # the one place: pyproject.toml reads it; tests hold the manifest and CHANGELOG.md to it
