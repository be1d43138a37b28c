"""Operators: gather from Blender, call the core or the worker process, report. No geometry here."""
