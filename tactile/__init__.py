"""The tactile layer: frames of three-axial taxel arrays in; events, loads and texture figures out."""
