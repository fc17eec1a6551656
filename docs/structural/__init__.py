"""What the pages `verification.md` and `cracking.md` are made of."""
