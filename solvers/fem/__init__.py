"""Finite elements in linear elasticity: spaces, matrices, linear equations, stresses, loads."""
