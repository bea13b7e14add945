"""What can be left out: effects in an order, the dear ones first, as long as their bounds together stay small."""

from tactile.simulator.choice.effect_bounds import EffectBounds
from tactile.simulator.choice.finger_bounds import FIELD, LeftOut


def negligible(bounds: EffectBounds, tolerance: float, rough: bool) -> tuple[set[str], float]:
    """What can be left out, with ``FIELD`` if it may be the field's accuracy, and the bound of the error."""
    sizes, zero, fields = bounds.sizes(), bounds.zero, {name for name, _ in bounds.on_fields}
    tried = {name for one in bounds.fingers for name in one.terms}
    # what is too large alone is not left out, but for what was tried, which may cancel
    small = [(size, name) for name, size in sizes.items() if (size <= tolerance or name in tried) and name not in zero]
    small.sort()
    order = [name for _, name in small if name in fields]
    order += [name for _, name in small if name not in fields]
    if rough and fields:
        order.insert(0, FIELD)
    off, joint = _left_out(bounds, order, fields, tolerance)
    while bounds.bends(off):
        joint = bounds.without(off).change(off)
        if joint <= tolerance:
            break
        # it does more beside the others than alone, as Poisson's ratio at the bottom of a layer
        order.remove(max(off & fields, key=lambda name: sizes[name]))
        off, joint = _left_out(bounds, order, fields, tolerance)
    return off | zero, joint


def _left_out(bounds: EffectBounds, order: list[str], fields: set[str], tolerance: float) -> tuple[set[str], float]:
    """What can be left out of the effects in an order, and the bound of the error."""
    off, joint, stepped = _greedy(bounds, order, tolerance)
    if not stepped:
        return off, joint
    # where a converter's steps are coarse nothing before it may be left out, or the converter itself
    steps = bounds.converters
    first = [name for name in order if name in steps]
    if not first:
        return off, joint
    more, change, _ = _greedy(bounds, first + [name for name in order if name not in steps], tolerance)
    return max((off, joint), (more, change), key=lambda one: (len(one[0] & fields), len(one[0])))


def _greedy(bounds: EffectBounds, order: list[str], tolerance: float) -> tuple[set[str], float, bool]:
    """What can be left out in an order, the bound of the error, and whether steps behind it let one stay."""
    most, joint, stepped = tolerance * bounds.peak, 0.0, False
    left, off = [LeftOut(finger) for finger in bounds.fingers], set[str]()
    for name in order:
        change = smooth = 0.0
        for one in left:
            plain, made = one.change(off, name)
            change, smooth = max(change, made), max(smooth, plain)
        if change <= most:
            for one in left:
                one.add(name)
            joint = change
            off.add(name)
        elif smooth <= most:
            stepped = True
    return off, joint / bounds.peak, stepped
