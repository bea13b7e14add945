"""What tests of touch share: pads, slides, scenes, effects, frames."""
