"""Progressive Meshes (Hoppe 1996) as a coded stream: a base mesh, then vertex splits in batches.

    simplify   collapses in order of their quadric error, batch by batch
    mesh       the receiver's mesh and the vertex split
    contexts   which rows of the coder's contexts belong to what
    places     where the two vertices of a split go <-> bits
    records    splits <-> bits; sender and receiver run the same function
    stream     header, base mesh and batches in bytes; any prefix past the base mesh decodes
"""
