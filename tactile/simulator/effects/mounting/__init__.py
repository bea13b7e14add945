"""Effects of how an array is mounted: where it lies, how thick its cover came out, how its surface is shaped."""
