"""Neural Subdivision (Liu et al., SIGGRAPH 2020) as a baseline: the network, and its training on our LoD sequences."""
