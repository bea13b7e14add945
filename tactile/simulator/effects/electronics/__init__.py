"""Effects of the electronics: mismatch, temperature, noise, amplifier, multiplexer."""
