"""Tables, figures and the HTML page: what people look at."""

from fd2fem.report.page import write_report
from fd2fem.report.tables import facade_summary

__all__ = ["facade_summary", "write_report"]
