"""The order that sorts integer keys: by their digits of 16 bits, the lowest first, for which numpy has a radix sort."""
import numpy as np

DIGIT = 16  # bits; numpy's stable sort of longer integers compares


def radix_argsort(keys: np.ndarray) -> np.ndarray:
    """Indices (k,) int64 that sort the integers keys (k,), none of them negative; equal keys stay in their order.

    >>> import numpy as np
    >>> from npm_blender.core.mesh import radix_argsort
    >>> radix_argsort(np.array([70000, 3, 70000, 5])).tolist()
    [1, 3, 0, 2]
    """
    keys = np.asarray(keys)
    order = np.argsort(keys.astype(np.uint16), kind="stable")
    for shift in range(DIGIT, int(keys.max(initial=0)).bit_length(), DIGIT):
        order = order[np.argsort((keys >> shift).astype(np.uint16)[order], kind="stable")]
    return order
