"""The order that sorts keys. numpy sorts numbers several times faster than it finds their order."""
import numpy as np


def order_of(keys: np.ndarray) -> np.ndarray:
    """Indices (k,) int64 that sort the integers keys (k,), none of them negative; equal keys stay in their order.

    Key and index are sorted as one number, where they fit into 63 bits.
    """
    keys = np.asarray(keys, np.int64)
    bits = len(keys).bit_length()
    if len(keys) == 0 or int(keys.max()).bit_length() + bits > 63:
        return np.argsort(keys, kind="stable")
    return np.sort((keys << bits) | np.arange(len(keys))) & ((1 << bits) - 1)
