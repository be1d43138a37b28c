"""Training of the network: `sequences` (meshes -> cached LoD sequences), `samples` (what a step needs), `losses`,
`train` (the loop), `curve` (a picture of its log).
"""
