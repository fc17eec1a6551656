"""The same wall in CalculiX, for a cross-check."""
