"""Tables: what a rig measured, read from CSV, Parquet or Arrow; what the sensor made of it, written."""

from vsensor.tables.cells import Floats
from vsensor.tables.findings import Findings
from vsensor.tables.layout import DEPTH_COLUMNS, Layout
from vsensor.tables.source import Head
from vsensor.tables.surface import SurfaceSamples, SurfaceTable, read_surface, surface_pieces
from vsensor.tables.times import TimeForm
from vsensor.tables.writer import (
    ESTIMATE_FIELDS,
    SURFACE_COLUMNS,
    TableWriter,
    check_writable,
    surface_columns,
    write_estimates,
    write_surface,
)

__all__ = [
    "DEPTH_COLUMNS",
    "ESTIMATE_FIELDS",
    "SURFACE_COLUMNS",
    "Findings",
    "Floats",
    "Head",
    "Layout",
    "SurfaceSamples",
    "SurfaceTable",
    "TableWriter",
    "TimeForm",
    "check_writable",
    "read_surface",
    "surface_columns",
    "surface_pieces",
    "write_estimates",
    "write_surface",
]
