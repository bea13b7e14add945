"""Effects of what stands between a taxel and its number: mismatch, temperature, noise, amplifier, multiplexer."""
