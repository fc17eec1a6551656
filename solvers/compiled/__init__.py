"""Everything that numba compiles: elements, their sums, and masonry at a point."""
