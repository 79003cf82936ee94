#!/bin/sh
# The pictures of the view that the documentation shows, one of each tab, of a minute's demonstration or of a session:
#
#     docs/pictures.sh [SESSION.mcap [WIDTHxHEIGHT]]
#
# Needs no screen, but an X server without one and Vulkan in software; on Debian and Ubuntu:
#     apt-get install xvfb xauth mesa-vulkan-drivers
set -eu
cd "$(dirname "$0")/.."

python=${PYTHON:-.venv/bin/python}
size=${2:-1600x900}
if ! command -v xvfb-run >/dev/null; then
    echo "$0: xvfb-run is missing: apt-get install xvfb xauth mesa-vulkan-drivers" >&2
    exit 1
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

session=${1:-}
if [ -z "$session" ]; then
    command="$PWD/$python"
    (cd "$work" && "$command" -m vsensor.cli.main demo --headless --duration 60)
    session=$(ls "$work"/recordings/*.mcap)
fi
# The binary, not the script `rerun` about it, which would orphan it when it is ended.
rerun=$("$python" -c 'from importlib.resources import files; print(files("rerun_cli") / "rerun")')

for tab in driller engineer service; do
    "$python" -m vsensor.cli.main view --session "$session" --tab "$tab" --save "$work/$tab.rrd"
    # The pointer stands in the middle of the X screen: on one so large it is outside of the window, and
    # points at nothing. RUST_LOG and CI: no messages, and no usage statistics sent to Rerun's makers.
    CI=1 RUST_LOG=error WGPU_BACKEND=vulkan timeout 300 \
        xvfb-run --auto-servernum --server-args '-screen 0 7000x4000x24' \
        "$rerun" --bind 127.0.0.1 --port auto "$work/$tab.rrd" --window-size "$size" \
        --screenshot-to "$work/$tab.png"
    if [ ! -s "$work/$tab.png" ]; then
        echo "$0: Rerun made no picture; is mesa-vulkan-drivers installed?" >&2
        exit 1
    fi
    # As large as a page shows it.
    "$python" -c '
import sys
from PIL import Image
picture = Image.open(sys.argv[1]).convert("RGB")
picture.thumbnail((1600, 900), Image.Resampling.LANCZOS)
picture.save(sys.argv[2], optimize=True)
' "$work/$tab.png" "docs/images/view-$tab.png"
done
