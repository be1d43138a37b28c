"""The queue of edges against a dictionary of prices."""
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from npm_blender.core.decimation.edge_heap import DEAD, REJECTED, heapify_edges, put_edge, take_edge

EDGES = 12
STEPS = st.lists(st.tuples(st.sampled_from(["put", "take", "pop"]), st.integers(0, EDGES - 1), st.integers(0, 5)), max_size=60)


def is_heap(heap, key, place, size):
    """Whether no edge is cheaper than the one above it, and all places are right."""
    return all(key[(at - 1) // 2] <= key[at] for at in range(1, size)) and all(place[heap[at]] == at for at in range(size))


@settings(deadline=None)  # the first call loads compiled code
@given(st.lists(st.integers(0, 5), max_size=EDGES), STEPS)
def test_holds_the_prices_that_were_put_and_the_cheapest_comes_first(first, steps):
    heap, key, place = np.full(EDGES, -7, np.int32), np.empty(EDGES), np.full(EDGES, REJECTED, np.int32)
    size = len(first)
    heap[:size], key[:size] = np.arange(size)[::-1], first
    prices = {int(heap[at]): key[at] for at in range(size)}
    heapify_edges(heap, key, place, size)
    for what, e, price in steps:
        if what == "put":
            size = put_edge(heap, key, place, e, float(price), size)
            prices[e] = price
        elif what == "take" or not size:
            size = take_edge(heap, key, place, e, DEAD, size)
            prices.pop(e, None)
            assert place[e] == DEAD
        else:
            e = int(heap[0])
            assert key[0] == min(prices.values())
            size = take_edge(heap, key, place, e, REJECTED, size)
            del prices[e]
            assert place[e] == REJECTED
        assert is_heap(heap, key, place, size)
        assert {int(heap[at]): key[at] for at in range(size)} == prices
