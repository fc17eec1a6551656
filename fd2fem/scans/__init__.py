"""Point clouds: reading, thinning, and the virtual scanner."""

from fd2fem.scans.las import write_las
from fd2fem.scans.rays import step_for_spacing
from fd2fem.scans.readers import Units, read_scan, read_scans
from fd2fem.scans.sampling import Density, resample, resample_to
from fd2fem.scans.scanner import ScannerOptions, simulate_scan
from fd2fem.scans.scene import Foliage, Neighbour, Post, Scene, Vehicle
from fd2fem.scans.street import default_stations, street_scene

__all__ = [
    "Density",
    "Foliage",
    "Neighbour",
    "Post",
    "ScannerOptions",
    "Scene",
    "Units",
    "Vehicle",
    "default_stations",
    "read_scan",
    "read_scans",
    "resample",
    "resample_to",
    "simulate_scan",
    "step_for_spacing",
    "street_scene",
    "write_las",
]
