"""The OpenCL device: its choice, name, memory and programs, and the settings for PoCL."""
