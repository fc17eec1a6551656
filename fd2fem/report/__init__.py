"""Tables, figures and the HTML page: what people look at."""

from fd2fem.report.page import write_report
from fd2fem.report.tables import facade_summary
from fd2fem.report.wall_figures import draw_cracked_walls, draw_cracks

__all__ = ["draw_cracked_walls", "draw_cracks", "facade_summary", "write_report"]
