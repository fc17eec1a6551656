"""What the ground does under a wall."""
