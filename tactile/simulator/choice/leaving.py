"""What can be left out: effects in an order, the dear ones first, as long as their bounds together stay small."""

from tactile.simulator.choice.effect_bounds import EffectBounds
from tactile.simulator.choice.finger_bounds import FIELD, LeftOut


def negligible(bounds: EffectBounds, tolerance: float, rough: bool) -> tuple[set[str], float]:
    """What can be left out, with ``FIELD`` if it may be the field's accuracy, and the bound of the error."""
    sizes = bounds.sizes()
    fields = {name for name, _ in bounds.on_fields}
    frames = [name for name in sizes if name not in fields and name not in bounds.zero]
    order = sorted(fields, key=lambda name: (sizes[name], name))
    order += sorted(frames, key=lambda name: (sizes[name], name))
    if rough and fields:
        sizes[FIELD] = 0.0
        order.insert(0, FIELD)
    off, joint = _left_out(bounds, order, fields, sizes, tolerance)
    while bounds.bends(off):
        joint = bounds.without(off).change(off)
        if joint <= tolerance:
            break
        # it does more beside the others than alone, as Poisson's ratio at the bottom of a layer
        order.remove(max(off & fields, key=lambda name: sizes[name]))
        off, joint = _left_out(bounds, order, fields, sizes, tolerance)
    return off, joint


def _left_out(
    bounds: EffectBounds, order: list[str], fields: set[str], sizes: dict[str, float], tolerance: float
) -> tuple[set[str], float]:
    """What can be left out of the effects in an order, and the bound of the error."""
    off, joint, stepped = _greedy(bounds, order, sizes, tolerance)
    if not stepped:
        return off, joint
    # where a converter's steps are coarse nothing before it may be left out, or the converter itself
    steps = bounds.converters
    more, change, _ = _greedy(bounds, sorted(order, key=lambda name: name not in steps), sizes, tolerance)
    return max((off, joint), (more, change), key=lambda one: (len(one[0] & fields), len(one[0])))


def _greedy(
    bounds: EffectBounds, order: list[str], sizes: dict[str, float], tolerance: float
) -> tuple[set[str], float, bool]:
    """What can be left out in an order, the bound of the error, and whether steps behind it let one stay."""
    fingers, most, joint, stepped = bounds.fingers, tolerance * bounds.peak, 0.0, False
    left = [LeftOut()] * len(fingers)
    tried = {name for one in fingers for name in one.terms}
    for name in order:
        if sizes[name] > tolerance and name not in tried:
            continue  # alone too large already; what was tried may cancel
        more = [one.without(gone, name) for one, gone in zip(fingers, left, strict=True)]
        changes = [one.change(gone) for one, gone in zip(fingers, more, strict=True)]
        smooth, change = changes[0] if len(changes) == 1 else map(max, zip(*changes, strict=True))
        if change <= most:
            left, joint = more, change
        elif smooth <= most:
            stepped = True
    return bounds.zero.union(left[0].names), joint / bounds.peak, stepped
