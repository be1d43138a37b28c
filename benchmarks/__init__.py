"""Benchmarks: `compare` (all methods at equal bytes and numbers, with its report), `speed`, `pictures`, `lod`."""
