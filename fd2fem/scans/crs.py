"""The unit of length that a LAS file's coordinate system names, as well-known text or as GeoTIFF keys."""

import re
from pathlib import Path
from typing import Any

from fd2fem.scans.units import Units

__all__ = ["declared_units"]

LAS_USER = "LASF_Projection"
WKT, GEO_KEYS = 2112, 34735
"""Record IDs of the LAS specification."""
MODEL, PROJECTED_UNIT, VERTICAL_UNIT = 1024, 3076, 4099
"""GeoTIFF keys: kind of the coordinates; linear units of x and y, and of z."""
GEOGRAPHIC = 2
EPSG_UNITS = {9001: Units.M, 9002: Units.FT, 9003: Units.US_FT}
FACTORS = (
    (1.0, Units.M),
    (0.3048, Units.FT),
    (1200.0 / 3937.0, Units.US_FT),
    (0.01, Units.CM),
    (0.001, Units.MM),
)
NUMBER = r"[-+0-9.eE]+"
UNIT = re.compile(rf'\b(?:LENGTH)?UNIT\["([^"]*)",({NUMBER})')
ELLIPSOID = re.compile(r'\b(?:ELLIPSOID|SPHEROID)\["[^"]*"(?:[^\[\]]|\[[^\[\]]*\])*\]')
ANGLE = re.compile(r"deg|rad|grad|gon", re.IGNORECASE)


def declared_units(path: Path, records: list[Any]) -> tuple[Units, str]:
    """Find the unit in the variable length records of a LAS file.

    Parameters
    ----------
    path : Path
        For the message.
    records : list of laspy.VLR

    Returns
    -------
    units : Units
        `Units.AUTO` where no record names one that is known.
    doubt : str
        Why the user must say the unit, where x, y and z are not in the same one; else empty.
    """
    found: set[Units] = set()
    for record in records:
        if record.user_id != LAS_USER:
            continue
        if record.record_id == WKT:
            found = _of_text(_text(record))
            break  # it takes precedence: it says what the keys can only number
        if record.record_id == GEO_KEYS:
            found = _of_keys({key.id: key.value_offset for key in record.geo_keys})
    if Units.AUTO in found:
        return Units.AUTO, f"{path} is in degrees of longitude and latitude: project it to metres."
    if len(found) > 1:
        names = " and ".join(sorted(found))
        return Units.AUTO, f"{path} has x and y in another unit than z, {names}: convert it to metres."
    return (found.pop() if found else Units.AUTO), ""


def _text(record: Any) -> str:
    data = record.string if hasattr(record, "string") else record.record_data
    return data if isinstance(data, str) else bytes(data).decode("utf-8", errors="replace")


def _of_text(wkt: str) -> set[Units]:
    """Units of length in well-known text; `Units.AUTO` stands for degrees.

    Examples
    --------
    >>> _of_text('PROJCS["a",GEOGCS["b",UNIT["degree",0.01745]],UNIT["US survey foot",0.3048006096012192]]')
    {<Units.US_FT: 'us-ft'>}
    """
    if not re.search(r"\b(PROJCS|PROJCRS|PROJECTEDCRS|LOCAL_CS|ENGCRS|ENGINEERINGCRS)\b", wkt):
        return {Units.AUTO} if re.search(r"\b(GEOGCS|GEOGCRS|GEOGRAPHICCRS)\b", wkt) else set()
    lengths = [(name, float(size)) for name, size in UNIT.findall(ELLIPSOID.sub("", wkt))]
    return {
        unit
        for name, size in lengths
        if not ANGLE.search(name)
        for factor, unit in FACTORS
        if abs(size / factor - 1.0) < 1e-7
    }


def _of_keys(keys: dict[int, int]) -> set[Units]:
    """Units of length in GeoTIFF keys; `Units.AUTO` stands for degrees."""
    if keys.get(MODEL) == GEOGRAPHIC:
        return {Units.AUTO}
    named = {keys.get(key) for key in (PROJECTED_UNIT, VERTICAL_UNIT)}
    return {EPSG_UNITS[code] for code in named if code in EPSG_UNITS}
