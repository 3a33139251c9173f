#!/bin/sh
# references.sh - makes the reference data of tests/render/test_peers.py anew.
#
# usage: MITSUBA=venv/bin/python CYCLES=venv/bin/python references.sh
# Interpreters that have mitsuba (pip install mitsuba; it wants DRJIT_LIBLLVM_PATH) and bpy 4.2 (pip
# install bpy==4.2.*), each with numpy. About ten minutes.
set -eu
python=${PYTHON:-/usr/bin/python3}
cd "$(dirname "$0")"
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT

# reference INTERPRETER SCRIPT SCENE SAMPLES: eight parts of SAMPLES each
reference() {
    module=${2%_render.py}
    "$python" scenes.py "$3" "$work/$3.json"
    for seed in 1 2 3 4 5 6 7 8; do
        "$1" "$2" "$work/$3.json" "$work/$seed.exr" --size 96x64 --spp "$4" --seed $seed
    done
    "$python" reference.py "$3.json" "$work"/[1-8].exr --scene "$3" --peer "$(peer_"$module" "$1")" \
        --command "scenes.py $3 $3.json; $2 $3.json SEED.exr --size 96x64 --spp $4 --seed SEED; SEED 1 to 8"
}

peer_mitsuba() { "$1" -c 'import mitsuba; print("Mitsuba", mitsuba.__version__)'; }
peer_cycles() { "$1" -c 'import bpy; print("Cycles of Blender", bpy.app.version_string)' | tail -1; }

reference "$MITSUBA" mitsuba_render.py cornell 2048
reference "$MITSUBA" mitsuba_render.py balls-white 4096
reference "$CYCLES" cycles_render.py balls 4096
