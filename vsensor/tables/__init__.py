"""Tables: what a rig measured, read from CSV, Parquet or Arrow; what the sensor made of it, written."""

from vsensor.tables.cells import Floats
from vsensor.tables.surface import (
    Layout,
    SurfaceSamples,
    SurfaceTable,
    read_surface,
    surface_pieces,
)
from vsensor.tables.times import TimeForm
from vsensor.tables.writer import (
    ESTIMATE_FIELDS,
    SURFACE_COLUMNS,
    TableWriter,
    check_writable,
    write_estimates,
    write_surface,
)

__all__ = [
    "ESTIMATE_FIELDS",
    "SURFACE_COLUMNS",
    "Floats",
    "Layout",
    "SurfaceSamples",
    "SurfaceTable",
    "TableWriter",
    "TimeForm",
    "check_writable",
    "read_surface",
    "surface_pieces",
    "write_estimates",
    "write_surface",
]
