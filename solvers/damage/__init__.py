"""How much a wall has suffered: strains, cracks, classes."""
