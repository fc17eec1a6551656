"""Walls that crack or let go of the ground, followed step by step."""
