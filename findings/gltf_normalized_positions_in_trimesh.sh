#!/usr/bin/env bash
# trimesh 5.2.0 reads a valid quantized .glb 32,767 times too large, without a word.
#
# glTF-Transform 4.5.1's `quantize` stores positions as normalized 16-bit integers, marks KHR_mesh_quantization as required
# and undoes the scale in the node. Khronos' validator (2.0.0-dev.3.10) finds no error and no warning in the file. trimesh
# neither divides by 32,767, as `"normalized": true` asks, nor refuses the required extension that it does not know: it takes
# the integers as coordinates and applies the node's scale to them.
#
# Seen: box 2 x 3 x 5 as written; 65,525 x 98,310 x 163,835 as read. A reader that stands on trimesh has to look at
# `extensionsRequired` and at the accessors itself.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

echo '{"type": "module"}' > package.json
npm install --silent --no-audit --no-fund @gltf-transform/core@4.5.1 @gltf-transform/extensions@4.5.1 \
    @gltf-transform/functions@4.5.1 gltf-validator@2.0.0-dev.3.10
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check trimesh==5.2.0 numpy

cat > write.mjs <<'JS'
import { readFileSync } from 'node:fs';
import { Document, NodeIO } from '@gltf-transform/core';
import { ALL_EXTENSIONS } from '@gltf-transform/extensions';
import { quantize } from '@gltf-transform/functions';
import validator from 'gltf-validator';

const document = new Document();
const buffer = document.createBuffer();
const corners = new Float32Array([0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 5]);
const faces = new Uint16Array([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
const primitive = document.createPrimitive()
  .setAttribute('POSITION', document.createAccessor().setType('VEC3').setArray(corners).setBuffer(buffer))
  .setIndices(document.createAccessor().setType('SCALAR').setArray(faces).setBuffer(buffer));
document.createScene().addChild(document.createNode().setMesh(document.createMesh().addPrimitive(primitive)));
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS);
await io.write('plain.glb', document);
await document.transform(quantize());
await io.write('quantized.glb', document);
const { issues } = await validator.validateBytes(new Uint8Array(readFileSync('quantized.glb')));
console.log(`validator: ${issues.numErrors} errors, ${issues.numWarnings} warnings`);
JS

cat > read.py <<'PY'
import trimesh

for name in ("plain", "quantized"):
    print(name, " x ".join(f"{side:,.0f}" for side in trimesh.load_scene(f"{name}.glb").extents))
PY

found=$(node write.mjs 2>/dev/null; venv/bin/python -W error read.py)
echo "$found"
expected="validator: 0 errors, 0 warnings
plain 2 x 3 x 5
quantized 65,525 x 98,310 x 163,835"
[ "$(grep -v '^prune' <<< "$found")" = "$expected" ] || { echo "Expected:"; echo "$expected"; exit 1; }
