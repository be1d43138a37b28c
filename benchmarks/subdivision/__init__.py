"""A subdivision codec without a network: a base mesh, a linear subdivision scheme, and one integer per new vertex.

    stencils   the scheme as sparse matrices
    shape      integers -> vertices (what a decoder does)
    symbols    integers <-> bytes, any prefix decodes
    fit        vertices of an input -> integers, at a rate; rates: the bits; descent: the integers one by one
    search     streams of one input: bases of several sizes, steps for a budget or in stages
    stream     header, base mesh and stages in bytes
"""
