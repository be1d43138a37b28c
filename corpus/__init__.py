"""Folders of meshes, and a function run over all of them in parallel processes: for benchmarks and for training."""
