import numpy as np


def test_rings_hold_the_faces_round_each_free_vertex_in_order(case):
    H, rings, _ = case
    for k, level in enumerate(H[1:]):
        for v in range(level.n):
            here = slice(rings.at[k, v], rings.at[k, v + 1])
            around, faces = rings.around[here], rings.faces[here]
            if rings.fixed[v]:
                assert len(around) == 0
                continue
            assert set(faces) == set(rings.first[k] + np.flatnonzero((level.F == v).any(1)))
            for f, p, q in zip(faces, around, np.roll(around, -1)):
                corner = list(rings.F[f]).index(v)
                assert list(np.roll(rings.F[f], -corner)) == [v, p, q]


def test_parents_are_the_ends_of_the_edge_that_a_vertex_halves(case):
    H, rings, _ = case
    assert (rings.parents[:H[0].n] == -1).all()
    for level in H[:-1]:
        assert np.array_equal(rings.parents[level.n:level.n + len(level.edges)], level.edges)
