"""Effects of the mounting: position of the array, thickness and shape of its cover."""
