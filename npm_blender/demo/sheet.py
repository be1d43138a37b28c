"""One picture of many meshes side by side, rendered by Blender: same view, same light, same scale, captions below.

All cells stand in one scene before one orthographic camera, so the sheet is one render, and no window or GPU is needed.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler

from ..core.mesh import TriMesh
from .quiet import quiet_stdout

CELL_WIDTH, CELL_HEIGHT, MARGIN = 1.0, 1.48, 0.07  # scene units; a cell is a picture over a caption
PICTURE_WIDTH, PICTURE_HEIGHT = 0.92, 1.08
PIXELS_PER_CELL = 380
SAMPLES = 8  # with the denoiser at its fastest; the demo has under a minute for everything, and clay shows no more
TURN, TILT = np.radians(24), np.radians(8)  # three-quarter view from slightly above
CLAY = (0.40, 0.235, 0.165, 1)
PAPER, INK, SOFT_INK = (0.83, 0.83, 0.84), (0.035, 0.035, 0.04), (0.16, 0.16, 0.18)


@dataclass(frozen=True)
class Cell:
    """One mesh of the sheet. mesh: in the frame that all cells share; lines: its caption; wire: draw its edges too."""

    mesh: TriMesh
    title: str
    lines: tuple[str, ...]
    wire: bool = False


def upright(mesh: TriMesh, up: str) -> TriMesh:
    """The mesh with z up, where `up` ('y' or 'z') is its up axis."""
    return mesh if up == "z" else TriMesh(mesh.V[:, [0, 2, 1]] * (1, -1, 1), mesh.F)


def render_sheet(rows: Sequence[Sequence[Cell]], path: Path) -> None:
    """Render the rows of cells to the PNG `path` (atomically). Replaces the open Blender scene.

    All meshes share one frame, z up; the first cell's mesh sets the view of all. Shorter rows are centred.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    columns = max(len(row) for row in rows)
    view = _View.fitting(rows[0][0].mesh.V)
    clay, wired = _clay("Clay", wire=False), _clay("Wired clay", wire=True)
    dark, soft = _ink("Ink", INK), _ink("Soft ink", SOFT_INK)
    shapes: dict[int, bpy.types.Mesh] = {}
    for r, row in enumerate(rows):
        for c, cell in enumerate(row):
            x, top = (c + 0.5 + (columns - len(row)) / 2) * CELL_WIDTH, -r * CELL_HEIGHT
            shape = shapes.get(id(cell.mesh)) or shapes.setdefault(
                id(cell.mesh), _mesh(view.apply(cell.mesh.V), cell.mesh.F)
            )
            thing = _placed(scene, shape, wired if cell.wire else clay)
            thing.location = (x, 0, top - MARGIN - PICTURE_HEIGHT / 2)
            line = top - MARGIN - PICTURE_HEIGHT - 0.11
            _text(scene, cell.title, x, line, 0.072, dark)
            for k, words in enumerate(cell.lines):
                _text(scene, words, x, line - 0.078 - 0.066 * k, 0.052, soft)
    _light(scene)
    _camera(scene, columns * CELL_WIDTH, len(rows) * CELL_HEIGHT)
    _render(scene, columns, len(rows), Path(path))


@dataclass(frozen=True)
class _View:
    """Three-quarter view: x = scale (turn @ p) - centre, fitted so that the source fills the picture of its cell."""

    turn: np.ndarray
    scale: float
    centre: np.ndarray

    @staticmethod
    def fitting(V: np.ndarray) -> "_View":
        turn = np.array(Euler((TILT, 0, 0)).to_matrix() @ Euler((0, 0, TURN)).to_matrix())
        low, high = (V @ turn.T).min(0), (V @ turn.T).max(0)
        width, _, height = np.maximum(high - low, 1e-30)
        scale = min(PICTURE_WIDTH / width, PICTURE_HEIGHT / height)
        return _View(turn, scale, scale * (low + high) / 2)

    def apply(self, V: np.ndarray) -> np.ndarray:
        return self.scale * (V @ self.turn.T) - self.centre


def _mesh(V: np.ndarray, F: np.ndarray) -> bpy.types.Mesh:
    data = bpy.data.meshes.new("Cell")
    data.vertices.add(len(V))
    data.vertices.foreach_set("co", V.astype(np.float32).ravel())
    data.loops.add(F.size)
    data.loops.foreach_set("vertex_index", F.ravel())
    data.polygons.add(len(F))
    data.polygons.foreach_set("loop_start", np.arange(0, F.size, 3, dtype=np.int32))
    data.update(calc_edges=True)
    data.shade_flat()
    return data


def _placed(scene: bpy.types.Scene, data: bpy.types.ID, material: bpy.types.Material) -> bpy.types.Object:
    thing = bpy.data.objects.new("Cell", data)
    scene.collection.objects.link(thing)
    if not data.materials:
        data.materials.append(None)
    slot = thing.material_slots[0]  # on the object: two cells may show one mesh, with and without wire
    slot.link, slot.material = "OBJECT", material
    return thing


def _clay(name: str, wire: bool) -> bpy.types.Material:
    """Matt clay; with `wire`, its triangles' edges drawn in a dark line of constant width."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    surface = nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = CLAY
    surface.inputs["Roughness"].default_value = 0.6
    if wire:
        edges = nodes.new("ShaderNodeWireframe")
        edges.use_pixel_size = True
        edges.inputs["Size"].default_value = 1.0
        mix = nodes.new("ShaderNodeMix")
        mix.data_type = "RGBA"
        mix.inputs["A"].default_value = CLAY
        mix.inputs["B"].default_value = (0.03, 0.02, 0.02, 1)
        links.new(edges.outputs["Fac"], mix.inputs["Factor"])
        links.new(mix.outputs["Result"], surface.inputs["Base Color"])
    return material


def _ink(name: str, colour: tuple[float, float, float]) -> bpy.types.Material:
    """A material of one colour whatever the light."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    emission, out = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Color"].default_value = (*colour, 1)
    tree.links.new(emission.outputs["Emission"], out.inputs["Surface"])
    return material


def _text(scene: bpy.types.Scene, text: str, x: float, z: float, size: float, material: bpy.types.Material) -> None:
    """Text centred at x on the line z, in front of everything."""
    curve = bpy.data.curves.new("Caption", "FONT")
    curve.body, curve.size, curve.align_x = text, size, "CENTER"
    caption = _placed(scene, curve, material)
    caption.location, caption.rotation_euler = (x, -2.0, z), (np.pi / 2, 0, 0)
    caption.visible_shadow = caption.visible_diffuse = False


def _light(scene: bpy.types.Scene) -> None:
    """Key from the upper left, rim from behind, soft sky; suns, so that every cell gets the same."""
    for name, strength, colour, angle, turn in (
        ("Key", 3.2, (1.0, 0.95, 0.88), 0.12, (48, 0, -50)),
        ("Fill", 0.4, (0.8, 0.9, 1.0), 0.5, (65, 0, 60)),
        ("Rim", 1.8, (0.85, 0.92, 1.0), 0.08, (-55, 0, 25)),
    ):
        sun = bpy.data.lights.new(name, "SUN")
        sun.energy, sun.color, sun.angle = strength, colour, angle
        thing = bpy.data.objects.new(name, sun)
        thing.rotation_euler = np.radians(turn)
        scene.collection.objects.link(thing)
    scene.world = world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    sky, paper, ray, mix = (
        nodes["Background"],
        *map(nodes.new, ("ShaderNodeBackground", "ShaderNodeLightPath", "ShaderNodeMixShader")),
    )
    sky.inputs["Color"].default_value = (0.75, 0.82, 0.95, 1)
    sky.inputs["Strength"].default_value = 0.35
    paper.inputs["Color"].default_value = (*PAPER, 1)
    links.new(ray.outputs["Is Camera Ray"], mix.inputs["Fac"])
    links.new(sky.outputs[0], mix.inputs[1])
    links.new(paper.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], nodes["World Output"].inputs["Surface"])


def _camera(scene: bpy.types.Scene, width: float, height: float) -> None:
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale, camera.clip_end = "ORTHO", max(width, height), 20
    thing = bpy.data.objects.new("Camera", camera)
    thing.location, thing.rotation_euler = (width / 2, -8, -height / 2), (np.pi / 2, 0, 0)
    scene.collection.objects.link(thing)
    scene.camera = thing


def _render(scene: bpy.types.Scene, columns: int, rows: int, path: Path) -> None:
    """Render with Cycles on the CPU: the one engine that needs no display."""
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x = columns * PIXELS_PER_CELL
    render.resolution_y = round(rows * PIXELS_PER_CELL * CELL_HEIGHT / CELL_WIDTH)
    scene.cycles.device = "CPU"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.seed = SAMPLES, True, 0
    scene.cycles.denoising_quality, scene.cycles.denoising_input_passes = "FAST", "RGB"
    scene.cycles.max_bounces = 2
    scene.view_settings.view_transform = "Standard"
    render.image_settings.file_format = "PNG"
    temporary = path.with_name(f".{path.stem}.part.png")
    render.filepath = str(temporary)
    with quiet_stdout():
        bpy.ops.render.render(write_still=True)
    os.replace(temporary, path)
