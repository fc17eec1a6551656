"""Short tables of records, for people and for ``--json``."""

from typing import Any

from fd2fem.model import Facade

__all__ = ["facade_summary"]


def facade_summary(facade: Facade) -> dict[str, Any]:
    """The figures of a facade that a user looks at first; JSON values, metres.

    Examples
    --------
    >>> from fd2fem.model import Facade, rectangle
    >>> facade_summary(Facade(rectangle(0, 0, 5, 6), 0.35))["length"]
    5.0
    """
    return {
        "length": facade.length,
        "height": facade.height,
        "thickness": facade.thickness,
        "storeys": [{"z": storey.z, "thickness": storey.thickness} for storey in facade.storeys],
        "opening_area": facade.opening_area,
        "openings": [
            {
                "id": opening.id,
                "kind": opening.kind.value,
                "x": opening.x,
                "z": opening.z,
                "width": opening.width,
                "height": opening.height,
                "confidence": opening.confidence,
            }
            for opening in facade.openings
        ],
        "filled_holes": [{"area": hole.area, "reason": hole.reason} for hole in facade.filled_holes],
        "points": dict(facade.record.get("points", {})),
        "warnings": list(facade.record.get("warnings", ())),
    }
