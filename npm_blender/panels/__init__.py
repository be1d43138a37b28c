"""Panels: draw from the properties of the active object; never decode, never change data."""
