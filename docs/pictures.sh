#!/bin/sh
# The picture of the live view that the documentation shows, of a file that `vsensor view --save` wrote:
#
#     docs/pictures.sh view.rrd docs/images/view.png [1600x900]
#
# Needs no screen, but an X server without one and Vulkan in software; on Debian and Ubuntu:
#     apt-get install xvfb mesa-vulkan-drivers
set -eu

if [ $# -lt 2 ]; then
    echo "usage: $0 RECORDING.rrd PICTURE.png [WIDTHxHEIGHT]" >&2
    exit 2
fi
recording=$1 picture=$2 size=${3:-1600x900}
python=${PYTHON:-.venv/bin/python}

if [ ! -r "$recording" ]; then
    echo "$0: $recording cannot be read: make one by: vsensor view CONFIG --save $recording" >&2
    exit 2
fi
if ! command -v xvfb-run >/dev/null; then
    echo "$0: xvfb-run is missing: apt-get install xvfb mesa-vulkan-drivers" >&2
    exit 1
fi
# The binary, not the script `rerun` about it, which would orphan it when it is ended.
rerun=$("$python" -c 'from importlib.resources import files; print(files("rerun_cli") / "rerun")')

# The pointer stands in the middle of the X screen: on one so large it is outside of the window, and
# points at nothing. RUST_LOG and CI: no messages, and no usage statistics sent to Rerun's makers.
rm -f "$picture"
CI=1 RUST_LOG=error WGPU_BACKEND=vulkan timeout 120 \
    xvfb-run --auto-servernum --server-args '-screen 0 7000x4000x24' \
    "$rerun" --bind 127.0.0.1 --port auto "$recording" --window-size "$size" --screenshot-to "$picture"

if [ ! -s "$picture" ]; then
    echo "$0: Rerun made no picture; is mesa-vulkan-drivers installed?" >&2
    exit 1
fi
