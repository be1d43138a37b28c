"""Benchmarks: `quality` (error per feature budget against QSlim, on a split of a corpus)."""
