"""Template files of other systems: CANDY ``.tem``, MATCNN ``temlib.m``, CNNSim text, the 19-number gene, celnn JSON."""
