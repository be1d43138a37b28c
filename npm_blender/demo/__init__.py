"""The demonstration: `sculpt` makes a mesh to compress, `sheet` renders what became of it. Both need Blender (bpy)."""
