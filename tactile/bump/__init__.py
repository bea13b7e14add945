"""The bump by finite elements: a hemisphere on the elastic body, under a rigid plate that sticks to it."""
