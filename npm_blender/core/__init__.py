"""Neural progressive meshes, without Blender: arrays in, bytes out, and back.

    TriMesh --clean--> TriMesh --decimate + ssp--> LodSequence M^0..M^L
        --encoder--> features f^0..f^(L-1) --refine--> --order--> ordered features
        --stream--> bytes  (base mesh first, then packets of features: every prefix past the base decodes)
    bytes --stream--> base mesh + the features that arrived --decoder--> TriMesh of level 0..L

`codec` is the two-function summary: compress and decompress. Nothing here imports bpy; torch is imported only where a
gradient is needed (`refine`, training).
"""
